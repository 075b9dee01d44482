// scene.json, its slices, and the run specification.
#include "records/scene.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <map>

#include "base/error.h"
#include "base/file.h"
#include "records/json.h"
#include "records/overrides.h"
#include "records/slices.h"

using namespace physmas;
namespace fs = std::filesystem;

namespace {

class Bundle {
 public:
  explicit Bundle(const std::string& name) : folder((fs::temp_directory_path() / ("physmas-unit-" + name)).string()) {
    fs::remove_all(folder);
    write_file(folder + "/gaussians.ply", "any bytes: slices only hash them");
    Json camera = {{"width", 8}, {"height", 8}, {"fx", 8}, {"fy", 8}, {"cx", 4}, {"cy", 4}};
    camera["world_to_camera"] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    json = {{"schema", "physmas/scene/1"}, {"name", "tiny"}, {"prompt", "it falls"}, {"gaussians", "gaussians.ply"}};
    for (const char* view : {"front", "right", "back", "left"}) {
      write_file(folder + "/views/" + view + ".png", view);
      json["views"].push_back({{"name", view}, {"image", std::string("views/") + view + ".png"}, {"camera", camera}});
    }
    json["output_cameras"] = Json::array({camera});
    json["run"] = Json::object();
    save();
  }
  void save() const { write_file(path(), json.dump()); }
  std::string path() const { return folder + "/scene.json"; }
  Scene load() const {
    save();
    return load_scene(path(), {true, true, true, true});
  }
  std::string failure() const {
    try {
      load();
    } catch (const Error& e) {
      CHECK(e.code() == ExitCode::invalid_input);
      return e.what();
    }
    FAIL("accepted");
    return "";
  }
  // The slices whose bytes differ from the last call's.
  std::string cut(const Json& overrides = Json::object()) {
    save();
    write_slices(path(), overrides, Json::object(), "", folder + "/spec");
    std::string changed;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder + "/spec")) {
      const std::string stage = entry.path().stem().string(), bytes = read_file(entry.path().string());
      if (slices[stage] != bytes) changed_stages.push_back(stage);
      slices[stage] = bytes;
    }
    std::sort(changed_stages.begin(), changed_stages.end());
    for (const std::string& stage : changed_stages) changed += (changed.empty() ? "" : " ") + stage;
    changed_stages.clear();
    return changed;
  }

  std::string folder;
  Json json;

 private:
  std::map<std::string, std::string> slices;
  std::vector<std::string> changed_stages;
};

std::string run_failure(const Json& run) {
  try {
    run_specification_from(run, "run.json", "/run");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a change reaches only the slices that depend on it") {
  Bundle bundle("slices");
  CHECK(bundle.cut() == "candidates ground lift material render screen simulate");
  CHECK(bundle.cut() == "");
  CHECK(bundle.cut({{"screening", {{"tau", 0.6}}}}) == "screen");
  CHECK(bundle.cut() == "screen");
  bundle.json["prompt"] = "it rises";
  CHECK(bundle.cut() == "ground");
  write_file(bundle.folder + "/gaussians.ply", "other bytes");
  CHECK(bundle.cut() == "ground lift render");
  write_file(bundle.folder + "/views/back.png", "other pixels");
  CHECK(bundle.cut() == "ground material");
  bundle.json["output_cameras"][0]["fx"] = 9;
  CHECK(bundle.cut() == "render");
  CHECK(bundle.cut({{"render", {{"sh_degree", 0}}}}) == "render");
}

TEST_CASE("another image size rescales the output cameras and keeps their vertical angle of view") {
  Bundle bundle("slice-size");
  bundle.cut();
  const Camera before = load_scene(bundle.path(), {}).output_cameras.at(0);
  CHECK(bundle.cut({{"render", {{"width", 3 * before.width}, {"height", 2 * before.height}}}}) == "render");
  const Camera after = load_scene(bundle.folder + "/spec/render.json", {}).output_cameras.at(0);
  CHECK(after.width == 3 * before.width);
  CHECK(after.height == 2 * before.height);
  CHECK(after.fy / after.height == doctest::Approx(before.fy / before.height));
  CHECK(after.fx / after.fy == doctest::Approx(before.fx / before.fy));
  CHECK(after.cx / after.width == doctest::Approx(before.cx / before.width));
}

TEST_CASE("a slice is a scene of its own that holds what its stage needs") {
  Bundle bundle("slice-read");
  bundle.cut();
  const Scene ground = load_scene(bundle.folder + "/spec/ground.json", {true, false, true, false});
  CHECK(ground.slice == "ground");
  CHECK(fs::exists(ground.views.at(3).image));
  const Scene lift = load_scene(bundle.folder + "/spec/lift.json", {false, true, false, false});
  CHECK(lift.prompt.empty());
  CHECK(fs::exists(lift.gaussians));
  CHECK_THROWS_WITH_AS(load_scene(bundle.folder + "/spec/lift.json", {true, false, false, false}),
                       doctest::Contains("/prompt"), Error);
  write_file(bundle.folder + "/gaussians.ply", "changed behind its back");
  CHECK_THROWS_WITH_AS(load_scene(bundle.folder + "/spec/lift.json", {}), doctest::Contains("/files/gaussians.ply"),
                       Error);
  CHECK_THROWS_WITH_AS(write_slices(bundle.folder + "/spec/lift.json", {}, {}, "", bundle.folder + "/x"),
                       doctest::Contains("/slice"), Error);
}

TEST_CASE("paths cannot leave the bundle") {
  for (const char* path : {"../gaussians.ply", "/etc/passwd", "a/../../b"}) {
    Bundle bundle("escape");
    bundle.json["gaussians"] = path;
    CHECK(bundle.failure().find("/gaussians") != std::string::npos);
  }
  Bundle bundle("escape");
  bundle.json["views"][2]["image"] = "../front.png";
  CHECK(bundle.failure().find("/views/2/image") != std::string::npos);
}

TEST_CASE("a wrong scene.json says what is wrong") {
  const auto failure = [](const std::function<void(Json&)>& change) {
    Bundle bundle("bad-scene");
    change(bundle.json);
    return bundle.failure();
  };
  CHECK(failure([](Json& j) { j["views"].erase(3); }).find("/views") != std::string::npos);
  CHECK(failure([](Json& j) { j["views"][1]["name"] = "front"; }).find("/views/1/name") != std::string::npos);
  CHECK(failure([](Json& j) { j["colour"] = 1; }).find("colour") != std::string::npos);
  CHECK(failure([](Json& j) { j["schema"] = "physmas/plan/1"; }).find("physmas/scene/1") != std::string::npos);
  CHECK(failure([](Json& j) { j["prompt"] = " \t"; }).find("/prompt") != std::string::npos);
  CHECK(failure([](Json& j) { j["prompt"] = ""; }).find("/prompt") != std::string::npos);
  CHECK(failure([](Json& j) { j.erase("prompt"); }).find("/prompt") != std::string::npos);
  CHECK(failure([](Json& j) { j["root"] = "."; }).find("/root") != std::string::npos);
  CHECK(failure([](Json& j) { j["output_cameras"].push_back(j["output_cameras"][0]); }).find("one per frame (50)") !=
        std::string::npos);
  CHECK(failure([](Json& j) { j["views"][0]["camera"]["world_to_camera"][0][0] = 2; }).find("rigid") !=
        std::string::npos);
  CHECK(failure([](Json& j) { j["run"]["grid"]["n"] = 4; }).find("/run") != std::string::npos);
}

TEST_CASE("a scene can be written and read") {
  Bundle bundle("scene-copy");
  const Scene scene = bundle.load();
  Provenance provenance;
  provenance.tool = "test";
  save_scene(bundle.folder + "/copy.json", scene, provenance);
  const Scene copy = load_scene(bundle.folder + "/copy.json", {true, true, true, true});
  CHECK(copy.name == scene.name);
  CHECK(copy.views[2].image == scene.views[2].image);
  CHECK(to_json(copy.run) == to_json(scene.run));
}

TEST_CASE("the run specification has the paper's defaults and checks itself") {
  const RunSpecification run = run_specification_from(Json::object(), "", "");
  CHECK(run.grid.n == 100);
  CHECK(run.time.frames == 50);
  CHECK(run.screening.tau == 0.72);
  CHECK(run.gravity.isApprox(Eigen::Vector3d(0, 0, -9.8)));
  CHECK(run_specification_from({{"placement", {{"up", "-y"}}}, {"gravity", -5}}, "", "")
            .gravity.isApprox(Eigen::Vector3d(0, 5, 0)));
  CHECK(run_specification_from(to_json(run), "", "").grid.n == 100);
  CHECK(to_json(run_specification_from(to_json(run), "", "")) == to_json(run));
  CHECK(run_failure({{"time", {{"substep_dt", 0.1}}}}).find("/run/time/substep_dt") != std::string::npos);
  CHECK(run_failure({{"time", {{"min_substep_dt", 0.01}}}}).find("/run/time/min_substep_dt") != std::string::npos);
  CHECK(run_failure({{"placement", {{"extent", 3}}}}).find("/run/placement") != std::string::npos);
  const auto collider = [](const Json& c) { return Json{{"colliders", Json::array({c})}}; };
  CHECK(run_failure(collider({{"type", "plane"}, {"point", {0, 0, 0}}})).find("/run/colliders/0") != std::string::npos);
  CHECK(run_failure(collider({{"type", "plane"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 0}}})).find("normal") !=
        std::string::npos);
  CHECK(run_failure(collider({{"type", "box"}, {"min", {1, 1, 1}}, {"max", {2, 0.5, 2}}})).find("max") !=
        std::string::npos);
}

TEST_CASE("settings from the command line become run overrides") {
  const Json run = run_overrides("", {"screening.tau=0.6", "placement.up=-y", "time.frames=20", "screening.tau=0.7"});
  CHECK(run["screening"]["tau"] == 0.7);
  CHECK(run["placement"]["up"] == "-y");
  CHECK(run["time"]["frames"] == 20);
  for (const char* bad : {"tau", "=1", "screening.tua=1", "screening.tau=high", "screening=1", "a.b.c=1"}) {
    CAPTURE(bad);
    try {
      run_overrides("", {bad});
      FAIL("accepted");
    } catch (const Error& e) {
      CHECK(e.code() == ExitCode::usage);
    }
  }
}
