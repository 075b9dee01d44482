#include "records/scene.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"

namespace fs = std::filesystem;

namespace physmas {
namespace {

std::string resolve_field(const Json& document, const char* field, const std::string& root, const std::string& path) {
  if (!document.contains(field)) return "";
  return resolve_inside(root, document.at(field).get<std::string>(), path, std::string("/") + field);
}

void check_file_hashes(const Json& document, const std::string& root, const std::string& path) {
  if (!document.contains("files")) return;
  for (const auto& [name, sha256] : document.at("files").items()) {
    const std::string file = resolve_inside(root, name, path, "/files");
    if (sha256_file(file) != sha256.get<std::string>()) {
      throw invalid_input({path, "/files/" + name, "a file that has changed since the slice was cut",
                           sha256.get<std::string>(), "run make again, or pm-scene slice"});
    }
  }
}

std::string relative_in(const std::string& file, const std::string& root) {
  const std::string relative = fs::path(file).lexically_relative(root).generic_string();
  if (relative.empty() || relative.rfind("..", 0) == 0) throw internal_error(file + " is outside the bundle " + root);
  return relative;
}

}  // namespace

Json resolve_run(const Json& document, const std::string& path, const std::string& root) {
  if (!document.contains("run")) return Json::object();
  if (!document.at("run").is_string()) return document.at("run");
  const std::string file = resolve_inside(root, document.at("run").get<std::string>(), path, "/run");
  Json run = load_record(file, "run");
  run.erase("schema");
  run.erase("provenance");
  return run;
}

void check_prompt(const std::string& prompt, const std::string& source) {
  const char* example = "for example \"it falls onto the floor\"";
  if (prompt.find_first_not_of(" \t\r\n") == std::string::npos)
    throw invalid_input({source, "", "a blank prompt", "a description of the motion", example});
  const long length = utf8_length(prompt);
  if (length < 0) throw invalid_input({source, "", "a prompt that is no UTF-8", "text in UTF-8"});
  if (length > kMaxPrompt) {
    throw invalid_input({source, "", fmt::format("a prompt of {} characters", length),
                         fmt::format("at most {}", kMaxPrompt), "say what moves, and how"});
  }
}

Scene load_scene(const std::string& path, const SceneNeeds& needs) {
  const Json document = load_record(path, "scene");
  Scene scene;
  scene.file = path;
  scene.root = folder_of(path);
  if (document.contains("slice")) {
    scene.slice = document.at("slice").get<std::string>();
    scene.root = (fs::path(scene.root) / document.value("root", ".")).lexically_normal().string();
    check_file_hashes(document, scene.root, path);
  } else if (document.contains("root") || document.contains("files")) {
    throw invalid_field(path, "/root", document.value("root", Json()), "nothing: only slices have root and files");
  }
  scene.name = document.at("name").get<std::string>();
  scene.prompt = document.value("prompt", "");
  if (document.contains("prompt") && scene.prompt.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw invalid_field(path, "/prompt", document.at("prompt"), "a prompt that is not blank");
  }
  scene.gaussians = resolve_field(document, "gaussians", scene.root, path);
  scene.inventory = resolve_field(document, "inventory", scene.root, path);
  scene.masks = resolve_field(document, "masks", scene.root, path);
  scene.materials = resolve_field(document, "materials", scene.root, path);
  scene.material_field = resolve_field(document, "material_field", scene.root, path);
  const Json views = document.value("views", Json::array());
  std::set<std::string> names;
  for (size_t i = 0; i < views.size(); ++i) {
    const std::string pointer = "/views/" + std::to_string(i);
    const Json& view = views[i];
    SceneView v;
    v.name = view.at("name").get<std::string>();
    if (!names.insert(v.name).second)
      throw invalid_field(path, pointer + "/name", view.at("name"), "a name of its own for each view");
    v.image = resolve_inside(scene.root, view.at("image").get<std::string>(), path, pointer + "/image");
    v.camera = camera_from(view.at("camera"), path, pointer + "/camera");
    scene.views.push_back(std::move(v));
  }
  const Json run = resolve_run(document, path, scene.root);
  scene.run = run_specification_from(run, path, "/run");
  const Json cameras = document.value("output_cameras", Json::array());
  for (size_t i = 0; i < cameras.size(); ++i) {
    scene.output_cameras.push_back(camera_from(cameras[i], path, "/output_cameras/" + std::to_string(i)));
  }
  if (cameras.size() > 1 && static_cast<int>(cameras.size()) != scene.run.time.frames) {
    throw invalid_input({path, "/output_cameras", std::to_string(cameras.size()) + " cameras",
                         fmt::format("one, or one per frame ({})", scene.run.time.frames)});
  }
  const auto require = [&](bool needed, bool present, const char* field, const char* what) {
    if (needed && !present) throw invalid_input({path, field, "nothing", what});
  };
  require(needs.prompt, !scene.prompt.empty(), "/prompt", "a motion prompt");
  require(needs.gaussians, !scene.gaussians.empty(), "/gaussians", "the path of the Gaussians");
  require(needs.views, scene.views.size() == 4, "/views", "four calibrated views");
  require(needs.output_cameras, !scene.output_cameras.empty(), "/output_cameras", "one camera, or one per frame");
  return scene;
}

void save_scene(const std::string& path, const Scene& scene, const Provenance& provenance) {
  const std::string root = folder_of(path);
  Json json;
  json["name"] = scene.name;
  json["prompt"] = scene.prompt;
  json["gaussians"] = relative_in(scene.gaussians, root);
  json["views"] = Json::array();
  for (const SceneView& view : scene.views) {
    Json entry;
    entry["name"] = view.name;
    entry["image"] = relative_in(view.image, root);
    entry["camera"] = to_json(view.camera);
    json["views"].push_back(entry);
  }
  json["output_cameras"] = Json::array();
  for (const Camera& camera : scene.output_cameras) json["output_cameras"].push_back(to_json(camera));
  if (!scene.inventory.empty()) json["inventory"] = relative_in(scene.inventory, root);
  if (!scene.masks.empty()) json["masks"] = relative_in(scene.masks, root);
  if (!scene.materials.empty()) json["materials"] = relative_in(scene.materials, root);
  if (!scene.material_field.empty()) json["material_field"] = relative_in(scene.material_field, root);
  json["run"] = to_json(scene.run);
  save_record(path, "scene", provenance, json);
}

}  // namespace physmas
