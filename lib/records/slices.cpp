#include "records/slices.h"

#include <filesystem>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"
#include "records/run_fields.h"
#include "records/scene.h"

namespace fs = std::filesystem;

namespace physmas {
namespace {

// What a stage's slice holds beside its part of the run specification.
struct SliceContent {
  const char* name;
  Stage stage;
  bool prompt, gaussians, view_images, view_cameras, output_cameras, authored;
  // Sections of the run specification that come first, the others follow in its order: artifacts name their slice by
  // its hash, so that it keeps the bytes that it has always had.
  std::vector<const char*> first;
};

const std::vector<SliceContent> kContents = {
    {"ground",
     kGround,
     true,
     true,
     true,
     true,
     false,
     true,
     {"grid", "walls", "placement", "time", "segmentation", "render"}},
    {"lift", kLift, false, true, false, true, false, false, {"grid", "walls"}},
    {"material", kMaterial, false, false, true, true, false, false, {}},
    {"candidates", kCandidates, false, false, false, false, false, false, {"grid", "walls", "time"}},
    {"simulate", kSimulate, false, false, false, false, false, false, {}},
    {"render", kRender, false, true, false, false, true, false, {"time", "render"}},
    {"screen", kScreen, false, false, false, false, false, false, {}},
};

// Whether the picture needs to know where up and the floor are.
bool needs_scene_axes(const RunSpecification::Render& render) {
  return render.has_floor() || render.shows_agents() ||
         render.camera_mode() == RunSpecification::Render::CameraMode::orbit;
}

Json run_part(const RunSpecification& run, const SliceContent& content) {
  const Json part = to_json(run, content.stage);
  Json ordered = Json::object();
  for (const char* section : content.first) ordered[section] = part.at(section);
  ordered.update(part);
  if (content.stage == kRender && needs_scene_axes(run.render)) {
    const Json whole = to_json(run);
    for (const char* section : {"grid", "placement", "colliders", "walls"}) ordered[section] = whole.at(section);
  }
  return ordered;
}

// Which rules a run has depends on it, so it is a fact for make.
void write_camera_fact(const RunSpecification::Render& render, const std::string& path) {
  if (render.camera_mode() == RunSpecification::Render::CameraMode::fixed) {
    std::error_code ignored;
    fs::remove(path, ignored);
    return;
  }
  write_file(path, std::string("PM_CAMERA := ") + kCameraModes[static_cast<size_t>(render.camera_mode())] + "\n");
}

// Files under `folder`, sorted, as paths relative to `root`.
std::vector<std::string> files_below(const std::string& folder, const std::string& root) {
  std::set<std::string> files;
  std::error_code failure;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, failure)) {
    if (entry.is_regular_file()) files.insert(fs::path(entry.path()).lexically_relative(root).generic_string());
  }
  return {files.begin(), files.end()};
}

// The scene's output cameras, at the size that `overrides` asks for: the vertical angle of view stays.
Json output_cameras_for(const Scene& scene, const Json& overrides) {
  Json cameras = Json::array();
  const Json render = overrides.contains("render") ? overrides.at("render") : Json::object();
  for (Camera camera : scene.output_cameras) {
    const int width = render.value("width", camera.width), height = render.value("height", camera.height);
    const double x = double(width) / camera.width, y = double(height) / camera.height;
    camera.fx *= y, camera.fy *= y, camera.cx *= x, camera.cy *= y;
    camera.width = width, camera.height = height;
    cameras.push_back(to_json(camera));
  }
  return cameras;
}

}  // namespace

void write_slices(const std::string& scene_path, const Json& overrides, const Json& defaults, const std::string& prompt,
                  const std::string& folder) {
  Json document = load_record(scene_path, "scene");
  if (!prompt.empty()) {
    check_prompt(prompt, "--prompt");
    document["prompt"] = prompt;
  }
  if (document.contains("slice"))
    throw invalid_field(scene_path, "/slice", document.at("slice"), "a whole scene, not a slice");
  const std::string root = folder_of(scene_path);
  Json run = defaults;
  run.merge_patch(resolve_run(document, scene_path, root));
  run.merge_patch(overrides);
  Json patched = document;
  patched["run"] = run;
  validate_record(patched, "scene", scene_path);
  const RunSpecification specification = run_specification_from(run, scene_path, "/run");
  const Scene scene = load_scene(scene_path, {true, true, true, true});
  const Json cameras = output_cameras_for(scene, overrides);
  // Absolute first: weakly_canonical leaves a relative path relative when its first folder does not exist yet.
  const fs::path slice_folder = fs::weakly_canonical(fs::absolute(folder));
  for (const SliceContent& content : kContents) {
    Json slice;
    slice["name"] = scene.name;
    slice["slice"] = content.name;
    slice["root"] = fs::weakly_canonical(root).lexically_relative(slice_folder).generic_string();
    Json files = Json::object();
    const auto add_file = [&](const std::string& relative) {
      files[relative] = sha256_file(resolve_inside(root, relative, scene_path, "/" + relative));
    };
    if (content.prompt) slice["prompt"] = document.at("prompt");
    if (content.gaussians) {
      slice["gaussians"] = document.at("gaussians");
      add_file(document.at("gaussians").get<std::string>());
    }
    if (content.view_cameras) {
      slice["views"] = document.at("views");
      if (content.view_images) {
        for (const Json& view : document.at("views")) add_file(view.at("image").get<std::string>());
      }
    }
    if (content.output_cameras) slice["output_cameras"] = cameras;
    if (content.authored && document.contains("inventory")) {
      slice["inventory"] = document.at("inventory");
      add_file(document.at("inventory").get<std::string>());
    }
    if (content.authored && document.contains("masks")) {
      slice["masks"] = document.at("masks");
      for (const std::string& file : files_below(scene.masks, root)) add_file(file);
    }
    if (content.stage == kMaterial && document.contains("materials")) {
      slice["materials"] = document.at("materials");
      add_file(document.at("materials").get<std::string>());
    }
    if (content.stage == kLift && document.contains("material_field")) {
      slice["material_field"] = document.at("material_field");
      add_file(document.at("material_field").get<std::string>());
    }
    if (!files.empty()) slice["files"] = files;
    slice["run"] = run_part(specification, content);
    Provenance provenance;
    provenance.tool = "pm-scene";
    save_record((slice_folder / (std::string(content.name) + ".json")).string(), "scene", provenance, slice);
  }
  write_camera_fact(specification.render, (slice_folder / "camera.mk").string());
}

}  // namespace physmas
