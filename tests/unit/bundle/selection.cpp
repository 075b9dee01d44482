#include <doctest/doctest.h>

#include <cmath>
#include <fstream>

#include "bundle/physgaussian.h"
#include "records/json.h"
#include "records/labels.h"
#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::bundle;
using Eigen::Vector3d;

namespace {

Gaussians row_of(int n) {
  Gaussians g;
  g.resize(n, 1);
  for (int i = 0; i < n; ++i) {
    g.position[i] = {static_cast<float>(i), 0, 0};
    g.opacity_logit[i] = static_cast<float>(i - n / 2);
    for (int k = 0; k < 4; ++k) g.sh[4 * i + k].setConstant(static_cast<float>(4 * i + k));
  }
  return g;
}

PhysGaussianImport import_of(const std::string& text) {
  const TemporaryFolder folder;
  std::ofstream(folder / "config.json") << text;
  return load_physgaussian(folder / "config.json");
}

std::string error_of(const std::string& text) {
  return message_of([&] { import_of(text); });
}

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  return text.find(part) != std::string::npos;
}

// Why `what` was not mapped; empty when it was.
std::string why(const PhysGaussianImport& import, const std::string& what) {
  for (const Omission& field : import.not_mapped) {
    if (field.what == what) return field.why;
  }
  return "";
}

bool omits(const PhysGaussianImport& import, const std::string& what) {
  return !why(import, what).empty();
}

void check_vector(const Json& json, const Vector3d& expected) {
  CHECK((vector3_from(json) - expected).norm() < 1e-12);
}

}  // namespace

TEST_CASE("selection: opacity and crop are strict, and what stays is unchanged") {
  Gaussians g = row_of(9);  // logits -4..4
  Selection selection;
  CHECK(select_gaussians(g, selection, "a.ply") == 0);
  CHECK(g.size() == 9);
  selection.opacity_threshold = 0.5;  // the middle one has exactly that
  CHECK(select_gaussians(g, selection, "a.ply") == 5);
  REQUIRE(g.size() == 4);
  CHECK(g.position[0].x() == 5);
  CHECK(g.sh_of(3)[2].y() == 4 * 8 + 2);
  CHECK(g.sh.size() == 16);
  selection.crop = crop_box({5, 8, -1, 1, -1, 1}, "--crop");
  CHECK(select_gaussians(g, selection, "a.ply") == 2);
  CHECK(g.position[0].x() == 6);
  selection.crop = crop_box({50, 80, -1, 1, -1, 1}, "--crop");
  CHECK(contains(message_of([&] { select_gaussians(g, selection, "a.ply"); }), "none of 2"));
  CHECK(contains(message_of([] { crop_box({1, 0, 0, 1, 0, 1}, "--crop"); }, ExitCode::usage), "along x"));
}

TEST_CASE("selection: floaters that shrink the scene are worth a warning, others are not") {
  Gaussians g;
  g.resize(1001, 0);
  for (int i = 0; i < 1000; ++i)
    g.position[i] = {static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100)};
  g.position[1000] = {10.5f, 5, 5};
  CHECK(find_floaters(g).count == 1);
  CHECK(floater_warning(find_floaters(g)).empty());
  g.position[1000] = {500, 5, 5};
  const Floaters floaters = find_floaters(g);
  CHECK(floaters.count == 1);
  CHECK(floaters.ratio > 40);
  CHECK(contains(floater_warning(floaters), "--crop"));
}

TEST_CASE("physgaussian: a whole configuration") {
  const PhysGaussianImport import = import_of(R"({
    "opacity_threshold": 0.02, "rotation_degree": [90.0], "rotation_axis": [0], "substep_dt": 1e-4, "frame_dt": 4e-2,
    "frame_num": 125, "nu": 0.4, "E": 2e6, "material": "jelly", "density": 200, "g": [0, 0, -9.8], "n_grid": 60,
    "sim_area": [-1, 1, -2, 2, 0, 3], "grid_v_damping_scale": 0.9999,
    "particle_filling": {"n_grid": 100, "max_partciels_per_cell": 2, "max_particles_num": 50000},
    "boundary_conditions": [
      {"type": "bounding_box"},
      {"type": "cuboid", "point": [1, 1, 0.5], "size": [0.5, 0.4, 0.28], "velocity": [0, 0, 0], "start_time": 0,
       "end_time": 1e3, "reset": 1},
      {"type": "surface_collider", "point": [1, 1, 0.2], "normal": [0, 0, 2], "surface": "slip", "friction": 0.3,
       "start_time": 0, "end_time": 1000},
      {"type": "cuboid", "point": [1, 1, 1], "size": [1, 1, 1], "velocity": [1, 0, 0]},
      {"type": "particle_impulse", "force": [-0.18, 0, 0]}],
    "additional_material_params": [], "init_azimuthm": -36.7, "mystery": 1})");
  // A quarter turn about x takes y to z: the scene's up is y.
  CHECK(import.up == "y");
  CHECK(import.run["placement"]["up"] == "y");
  CHECK(import.run["grid"]["n"] == 60);
  CHECK(import.run["grid"]["length"] == 2);
  CHECK(import.run["time"]["frames"] == 126);
  CHECK(import.run["time"]["substep_dt"] == 1e-4);
  check_vector(import.run["gravity"], {0, -9.8, 0});
  CHECK(import.run["particles"] == Json({{"fill", true}, {"per_cell", 2}, {"max", 50000}}));
  CHECK(import.selection.opacity_threshold == 0.02);
  REQUIRE(import.selection.crop);
  // solver y in -2..2 is scene -z, solver z in 0..3 is scene y.
  CHECK((import.selection.crop->min() - Vector3d(-1, 0, -2)).norm() < 1e-12);
  CHECK((import.selection.crop->max() - Vector3d(1, 3, 2)).norm() < 1e-12);
  REQUIRE(import.run["colliders"].size() == 2);
  const Json &box = import.run["colliders"][0], &plane = import.run["colliders"][1];
  CHECK(box["mode"] == "sticky");
  check_vector(box["min"], {0.5, 0.22, 0.6});
  check_vector(box["max"], {1.5, 0.78, 1.4});
  CHECK(plane["mode"] == "slip");
  check_vector(plane["point"], {1, 0.2, 1});
  check_vector(plane["normal"], {0, 1, 0});
  CHECK(import.label == kRubber);
  CHECK(import.E == 2e6);
  for (const char* what : {"/density", "/grid_v_damping_scale", "/boundary_conditions/3 (cuboid)",
                           "/boundary_conditions/4 (particle_impulse)", "/additional_material_params", "/init_azimuthm",
                           "/mystery", "/particle_filling/n_grid", "/sim_area"}) {
    INFO(what);
    CHECK(omits(import, what));
  }
}

TEST_CASE("physgaussian: colliders are what lasts as long as the run; motions are named in scene axes") {
  // 2 s; a quarter turn about z takes the scene's x to PhysGaussian's y.
  const PhysGaussianImport import = import_of(R"({
    "rotation_degree": [90], "rotation_axis": [2], "frame_dt": 0.02, "frame_num": 100, "boundary_conditions": [
      {"type": "cuboid", "point": [1, 1.5, 1], "size": [0.1, 0.2, 0.3], "velocity": [0, 0, 0], "end_time": 2.0},
      {"type": "cuboid", "point": [1, 1, 1], "size": [1, 1, 1], "velocity": [0, 0, 0], "end_time": 1.9},
      {"type": "cuboid", "point": [1, 1, 1], "size": [1, 1, 1], "velocity": [0, 0.5, 0], "start_time": 0.5, "end_time": 1e3},
      {"type": "enforce_particle_translation", "point": [1, 1, 1], "size": [1, 1, 1], "velocity": [0.2, 0, 0],
       "start_time": 0, "end_time": 1e3},
      {"type": "enforce_particle_translation", "point": [1, 1, 1], "size": [1, 1, 1], "velocity": [0, 0, 0],
       "start_time": 0, "end_time": 0.5},
      {"type": "enforce_particle_velocity_rotation", "point": [1, 1, 1], "normal": [0, 0, 2],
       "half_height_and_radius": [0.2, 0.1], "rotation_scale": 1.9, "translation_scale": 0, "start_time": 0, "end_time": 3},
      {"type": "particle_impulse", "force": [0, 0, -0.18], "num_dt": 3, "start_time": 0.25},
      {"type": "release_particles_sequentially", "normal": [1, 0, 0], "start_position": 1.5, "end_position": 0.5,
       "num_layers": 50, "start_time": 0, "end_time": 1.5},
      {"type": "surface_collider", "point": [1, 1, 0.2], "normal": [0, 1, 1], "surface": "cut", "friction": 0},
      {"type": "surface_collider", "point": [1, 1, 0.2], "normal": [0, 3, 4], "surface": "separate", "friction": 0.5,
       "start_time": 0, "end_time": 5},
      {"type": "surface_collider", "point": [1, 1, 0.2], "normal": [0, 1, 1], "surface": "sticky", "friction": 0,
       "start_time": 1, "end_time": 5},
      {"type": "wind"}]})");
  REQUIRE(import.run["colliders"].size() == 2);
  const Json &box = import.run["colliders"][0], &plane = import.run["colliders"][1];
  check_vector(box["min"], {1.3, 0.9, 0.7});
  check_vector(box["max"], {1.7, 1.1, 1.3});
  CHECK(plane["mode"] == "separate");
  CHECK(plane["friction"] == 0.5);
  check_vector(plane["normal"], {0.6, 0, 0.8});
  const auto reason = [&](int i, const char* type) {
    return why(import, "/boundary_conditions/" + std::to_string(i) + " (" + type + ")");
  };
  CHECK(contains(reason(1, "cuboid"), "from 0 s to 1.9 s only"));
  CHECK(contains(reason(2, "cuboid"), "along x at 0.5 m/s from 0.5 s to 2 s"));
  CHECK(contains(reason(3, "enforce_particle_translation"), "moved along -y at 0.2 m/s;"));
  CHECK(contains(reason(4, "enforce_particle_translation"), "held from 0 s to 0.5 s;"));
  CHECK(contains(reason(5, "enforce_particle_velocity_rotation"), "turned about -z at 1.9 rad/s;"));
  CHECK(contains(reason(6, "particle_impulse"), "0.18 N each along -z for 3 steps from 0.25 s"));
  CHECK(contains(reason(7, "release_particles_sequentially"), "no action"));
  CHECK(contains(reason(8, "surface_collider"), "specific"));
  CHECK(contains(reason(10, "surface_collider"), "from 1 s to 2 s only"));
  CHECK(contains(reason(11, "wind"), "unknown"));
}

TEST_CASE("physgaussian: what a configuration leaves out has PhysGaussian's default") {
  const PhysGaussianImport import = import_of("{}");
  CHECK(import.up == "z");
  CHECK(import.run["grid"]["n"] == 50);
  CHECK(import.run["time"]["frame_dt"] == 1e-2);
  CHECK(import.run["time"]["frames"] == 101);
  CHECK(import.run["particles"]["fill"] == false);
  CHECK(import.run["colliders"].empty());
  CHECK(import.E == 1e5);
  CHECK_FALSE(import.selection.crop);
}

TEST_CASE("physgaussian: the label is the branch's nearest in E, then in density") {
  CHECK(import_of(R"({"material": "metal", "E": 2e6, "density": 1000})").label == kPlastic);
  CHECK(import_of(R"({"material": "metal", "E": 1e11, "density": 7000})").label == kMetal);
  CHECK(import_of(R"({"material": "foam", "E": 1e5, "density": 90})").label == kFoam);
  CHECK(import_of(R"({"material": "sand"})").label == kSand);
}

TEST_CASE("physgaussian: hints are a valid record, for rows and for the whole object") {
  const PhysGaussianImport import = import_of(R"({"material": "snow"})");
  for (const std::vector<std::string>& keys : {std::vector<std::string>{}, {"cake/sponge", "cake/icing"}}) {
    Json record = material_hints(import, keys);
    record["schema"] = "physmas/material_records/1";
    validate_record(record, "material_records", "hints");
    CHECK(record["rows"].size() == keys.size());
    CHECK(record["whole_object"]["label"] == "Snow");
  }
}

TEST_CASE("physgaussian: the scene is turned by rotations that are no quarter turns; all else is PhysGaussian's then") {
  const PhysGaussianImport import = import_of(R"({"rotation_degree": [30, 90], "rotation_axis": [2, 0], "g": [0, 1, -9],
    "sim_area": [-3, 1, -4, 2, -5, 3], "boundary_conditions": [{"type": "cuboid", "point": [1, 1, 0.5],
    "size": [0.5, 0.4, 0.3], "velocity": [0, 0, 0]}, {"type": "particle_impulse", "force": [0, 2, 0]}]})");
  // First x towards y by 30 degrees, then y to z.
  const double c = std::sqrt(0.75), s = 0.5;
  CHECK((import.turn * Vector3d::UnitX() - Vector3d(c, 0, s)).norm() < 1e-12);
  CHECK((import.turn * Vector3d::UnitY() - Vector3d(-s, 0, c)).norm() < 1e-12);
  CHECK((import.turn * Vector3d::UnitZ() - Vector3d(0, -1, 0)).norm() < 1e-12);
  CHECK(import.up == "z");
  check_vector(import.run["gravity"], {0, 1, -9});
  REQUIRE(import.run["colliders"].size() == 1);
  check_vector(import.run["colliders"][0]["min"], {0.5, 0.6, 0.2});
  check_vector(import.run["colliders"][0]["max"], {1.5, 1.4, 0.8});
  CHECK(contains(why(import, "/boundary_conditions/1 (particle_impulse)"), "along y"));
  CHECK_FALSE(omits(import, "/rotation_degree"));
  // The area is of the turned scene: scene x 3 is (3c, 0, 3s) there, scene y -5 is (5s, 0, -5c).
  Gaussians g;
  g.resize(4, 0);
  g.position = {{0, 0, 0}, {3, 0, 0}, {-2, 0, 0}, {0, -5, 0}};
  CHECK(select_gaussians(g, import.selection, "f") == 2);
  CHECK(g.position[1].x() == -2);

  CHECK(import_of(R"({"rotation_degree": [90, 180], "rotation_axis": [2, 0]})").turn == Eigen::Matrix3d::Identity());
}

TEST_CASE("physgaussian: broken configurations are refused by field") {
  CHECK(contains(error_of("[]"), "an object"));
  CHECK(contains(error_of(R"({"material": "water"})"), "/material"));
  CHECK(contains(error_of(R"({"nu": 0.5})"), "/nu"));
  CHECK(contains(error_of(R"({"n_grid": 5})"), "/n_grid"));
  CHECK(contains(error_of(R"({"E": "hard"})"), "/E"));
  CHECK(contains(error_of(R"({"frame_num": 1e9})"), "/frame_num"));
  CHECK(contains(error_of(R"({"rotation_degree": [90]})"), "/rotation_axis"));
  CHECK(contains(error_of(R"({"sim_area": [1, 0, 0, 1, 0, 1]})"), "/sim_area"));
  CHECK(contains(error_of(R"({"substep_dt": 1, "frame_dt": 0.1})"), "substep_dt"));
  CHECK(contains(error_of(R"({"boundary_conditions": [{"type": "surface_collider", "surface": "odd"}]})"), "/surface"));
}
