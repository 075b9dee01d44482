#include "bundle/import_bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "base/output.h"
#include "bundle/captured_views.h"
#include "bundle/dataparser_transform.h"
#include "bundle/dense_component.h"
#include "bundle/material_files.h"
#include "bundle/physgaussian.h"
#include "bundle/scene_doubts.h"
#include "bundle/user_views.h"
#include "bundle/view_rig.h"
#include "bundle/views.h"
#include "records/inventory.h"
#include "records/json.h"
#include "records/known_names.h"
#include "records/labels.h"
#include "records/scene.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "scene/neighbors.h"
#include "scene/placement.h"
#include "splat/turned_gaussians.h"

namespace fs = std::filesystem;

namespace physmas::bundle {
namespace {

constexpr size_t kMaxName = 64;  // bytes of an id
constexpr double kFloorFriction = 0.45;
constexpr double kFloorRoom = 2;  // cells between the lower wall and the floor that we add
// A second simulation of a scene of few particles may take more substeps than the default: a minute on one core.
constexpr double kRetryParticleSteps = 2e9, kMostSubsteps = 1e9;
constexpr double kOutputFov = 40, kOutputMargin = 0.12;

// "My Guitar.compressed.ply" -> "my-guitar".
std::string name_from(const std::string& path) {
  std::string name;
  for (const char c : fs::path(path).filename().string()) {
    if (c == '.') break;
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) && static_cast<unsigned char>(c) < 128;
    if (plain) name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (!plain && !name.empty() && name.back() != '-') name += '-';
  }
  name = name.substr(0, kMaxName);
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name.empty() ? "scene" : name;
}

std::vector<CopiedFile> read_masks(const ImportOptions& options, const std::vector<SceneView>& views) {
  std::vector<CopiedFile> files;
  std::error_code failure;
  if (!fs::is_directory(options.masks, failure))
    throw invalid_input({options.masks, "", "no folder", "a folder with masks"});
  std::set<std::string> paths;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(options.masks)) {
    if (entry.is_regular_file() && entry.path().extension() == ".png") paths.insert(entry.path().string());
  }
  if (paths.empty()) throw invalid_input({options.masks, "", "no mask", "VIEW/OBJECT.png or VIEW/OBJECT/PART.png"});
  for (const std::string& path : paths) {
    const fs::path relative = fs::path(path).lexically_relative(options.masks);
    const auto view = std::find_if(views.begin(), views.end(),
                                   [&](const SceneView& v) { return v.name == relative.begin()->string(); });
    if (view == views.end())
      throw invalid_input({path, "", "a mask of no view", "a folder per view, named as the view"});
    const Image mask = load_image(path);
    if (mask.width != view->camera.width || mask.height != view->camera.height) {
      throw invalid_input({path, "", fmt::format("a mask of {} x {} pixels", mask.width, mask.height),
                           fmt::format("{} x {} as the view's camera says", view->camera.width, view->camera.height)});
    }
    files.push_back({options.folder + "/masks/" + relative.generic_string(), read_file(path)});
  }
  return files;
}

// The finest grid on which Plastic at its default modulus, the material of every row without evidence, can be
// integrated at the run's smallest step. A particle that is alone in its cell oscillates with the speed of the
// isotropic mode, which is the limit: sqrt((3 lambda + 2 mu) / rho) dt < dx. A tenth of that is kept back.
int stable_grid(const RunSpecification& run) {
  const LabelPrior& plastic = kLabels[*find_label("Plastic")];
  const double E = plastic.E_default(), nu = plastic.nu_default();
  const double bulk_modulus_times_3 = E / (1 - 2 * nu);
  const double speed = std::sqrt(bulk_modulus_times_3 / plastic.rho);
  const double dt = std::max(run.time.min_substep_dt, run.time.frame_dt / run.time.max_substeps);
  return static_cast<int>(0.9 * run.grid.length / (speed * dt));
}

// The paper's grid, or a coarser one where the scene needs it. The Gaussians must be dense enough: 90 % of them shall
// have three others within a cell, because particles that are more than a cell apart do not feel each other and a
// sparse scene would fall to dust. And the fallback material must be stable.
int grid_for(const Gaussians& gaussians, const RunSpecification& run) {
  constexpr int kNeighbours = 3, kCoarsest = 32;
  const int count = static_cast<int>(gaussians.size());
  if (count <= kNeighbours) return kCoarsest;
  std::vector<int32_t> all(gaussians.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<double> distance = NeighborSearch<3>(gaussians.position, all).squared_to_nth(kNeighbours);
  const size_t rank = gaussians.size() * 9 / 10;
  std::nth_element(distance.begin(), distance.begin() + rank, distance.end());
  const double cell = std::sqrt(distance[rank]) * solver_map(gaussians, run).s;
  if (!(cell > 0)) return kCoarsest;
  const int sampled = static_cast<int>(std::min(run.grid.length / cell, 1e6));
  return std::max(kCoarsest, std::min({sampled, stable_grid(run), run.grid.n}));
}

// The user's specification with what it leaves open: up, grid, placement and floor. json: what lies below it, an
// imported configuration or nothing.
RunSpecification run_for(const ImportOptions& options, Json json, const Gaussians& gaussians) {
  const std::string file = options.run.empty() ? "--drop" : options.run;
  bool asked_grid = false;  // by the user's own specification
  if (!options.run.empty()) {
    const Json own = load_record(options.run, "run");
    asked_grid = own.contains("/grid/n"_json_pointer);
    json.merge_patch(own);
    json.erase("schema");
    json.erase("provenance");
    if (json.value("/placement/up"_json_pointer, options.up) != options.up) {
      throw invalid_field(options.run, "/placement/up", json["placement"]["up"],
                          "the axis that --up gives, \"" + options.up + "\"");
    }
  }
  Json paper = json;
  paper["placement"]["up"] = options.up;
  const RunSpecification given = run_specification_from(paper, file, "");
  if (!json.contains("/grid/n"_json_pointer)) {
    json["grid"]["n"] = grid_for(gaussians, given);
  } else if (asked_grid && given.time.rule == "paper" && given.grid.n > stable_grid(given)) {
    log_warning(
        fmt::format("{}: grid.n = {}, but what has no material of its own, Plastic, is stable on at most {} "
                    "cells at these time steps: leave grid.n out, or lower time.min_substep_dt and raise "
                    "time.max_substeps",
                    file, given.grid.n, stable_grid(given)));
  }
  // Where things will be is not known here: the camera is fitted once it is (lib/splat/fitted_camera.h).
  if (!json.contains("/render/camera"_json_pointer)) json["render"]["camera"] = "fit";
  const bool own_center = json.contains("/placement/center"_json_pointer), own_colliders = json.contains("colliders");
  json["placement"]["up"] = options.up;
  // Parts are told apart by what each view sees: without the depth test, a part also claims what lies behind it
  // (docs/method-lifting.md has the accuracies). Whoever wants the paper's rule says so in --run.
  if (!options.inventory.empty() && !json.contains("/lifting/occlusion"_json_pointer)) {
    json["lifting"]["occlusion"] = "depth";
  }
  // A captured scene may have any material; whoever imports one wants a video rather than the paper's step.
  if (!json.contains("/time/on_divergence"_json_pointer)) json["time"]["on_divergence"] = "cfl";
  if (!json.contains("/time/stiff"_json_pointer)) json["time"]["stiff"] = "auto";
  if (!json.contains("/time/retry_substeps"_json_pointer)) {
    const double particles = static_cast<double>(std::max<size_t>(1, given.particles.simulated(gaussians.size())));
    const double substeps = std::min(kRetryParticleSteps / particles, kMostSubsteps);
    json["time"]["retry_substeps"] = std::max(given.time.retry_substeps, static_cast<int>(substeps));
  }
  // What stands in a capture has stood, and is not to sag first. Nothing changes for what starts in the air.
  if (!json.contains("/time/start"_json_pointer)) json["time"]["start"] = "equilibrium";
  RunSpecification run = run_specification_from(json, file, "");
  if (own_colliders) return run;
  const Heights walls = wall_heights(run);
  if (!own_center) {
    // As low as the walls allow: the cube of edge `extent` around the scene must stay inside them.
    const Heights scene = heights_of(gaussians, run);
    const double half = 0.5 * (scene.highest - scene.lowest);
    const double center = std::max(walls.lowest + 0.5 * run.placement.extent + 1e-6,
                                   walls.lowest + kFloorRoom * run.grid.dx() + options.drop + half);
    const Eigen::Vector3d up = run.placement.up_vector();
    run.placement.center += (center - up.dot(run.placement.center)) * up;
    json["placement"]["center"] = to_json(run.placement.center);
    if (center + 0.5 * run.placement.extent > walls.highest) {
      throw invalid_input({file, "",
                           fmt::format("a drop of {} below a scene of extent {}", options.drop, run.placement.extent),
                           "both inside the walls of the solver's cube", "make --drop or placement.extent smaller"});
    }
  }
  const double height = heights_of(gaussians, run).lowest - options.drop;
  if (height < walls.lowest) {
    throw invalid_input({file, "/placement/center", fmt::format("a floor at height {:.3f}", height),
                         fmt::format("one above the lower wall, at {:.3f}", walls.lowest), "make --drop smaller"});
  }
  run = run_specification_from(json, file, "");
  run.colliders.push_back(floor_at(height, run));
  run.colliders.back().friction = kFloorFriction;
  return run;
}

// The scene where it is and where it would lie after falling to the floor.
std::vector<Eigen::Vector3d> points_to_frame(std::vector<Eigen::Vector3d> points, const Gaussians& gaussians,
                                             const RunSpecification& run) {
  const size_t count = points.size();
  const SolverMap map = solver_map(gaussians, run);
  const Eigen::Vector3d up = run.placement.up_vector();
  for (const RunSpecification::Collider& c : run.colliders) {
    if (c.type != RunSpecification::Collider::Type::plane || c.normal.dot(up) < 0.99) continue;
    const double fall = (heights_of(gaussians, run).lowest - c.point.dot(up)) / map.s;
    for (size_t i = 0; i < count; ++i) points.push_back(points[i] - std::max(0.0, fall) * up);
  }
  return points;
}

void remove_other_masks(const std::string& folder, const std::vector<CopiedFile>& masks) {
  std::set<std::string> kept;
  for (const CopiedFile& file : masks) kept.insert(fs::path(file.to).lexically_normal().string());
  std::vector<fs::path> stale;
  std::error_code failure;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, failure)) {
    if (entry.is_regular_file() && kept.count(entry.path().lexically_normal().string()) == 0)
      stale.push_back(entry.path());
  }
  for (const fs::path& path : stale) fs::remove(path, failure);
}

}  // namespace

namespace {

// Up, where neither the user nor a configuration says it: nerfstudio turns captures so that z is up, some files say it,
// other captures have y down.
std::string usual_up(const ImportOptions& options, const GaussianNotes& notes) {
  if (!options.dataparser.empty()) return "z";
  return notes.up.empty() ? "-y" : notes.up;
}

// What --front says where the views are rendered.
double front_without_views(const ImportOptions& options) {
  const std::optional<double> degrees = options.front.empty() ? 0 : front_degrees(options.front, options.up);
  if (!degrees) {
    throw Error(ExitCode::usage,
                fmt::format("--front: found \"{}\", expected x, y, z, -x, -y or -z across up, or degrees from -360 to "
                            "360; a view's name needs --cameras",
                            one_line(options.front, 80)));
  }
  return *degrees;
}

// What `dataparser` stands for: a file, or empty.
std::string dataparser_file(const ImportOptions& options) {
  if (options.cameras.empty() || options.dataparser == "none") return "";
  if (!options.dataparser.empty()) return options.dataparser;
  const std::string found = find_dataparser_transform(options.gaussians, options.cameras);
  if (!found.empty()) log_info("cameras moved by " + found);
  return found;
}

// An imported configuration goes below what the user says. Returns its run specification.
Json take_configuration(const PhysGaussianImport& configuration, ImportOptions& options) {
  if (options.up.empty()) options.up = configuration.up;
  if (!options.selection.crop) {
    options.selection.crop = configuration.selection.crop;
    options.selection.crop_axes = configuration.selection.crop_axes;
  }
  if (options.selection.opacity_threshold == 0) {
    options.selection.opacity_threshold = configuration.selection.opacity_threshold;
  }
  if (options.up != configuration.up) {
    throw Error(ExitCode::usage, fmt::format("--up: found {}, expected {} as {} has it", options.up, configuration.up,
                                             options.physgaussian));
  }
  Json run = configuration.run;
  run.erase("schema");
  return run;
}

// The axis and the angle.
std::string rotation_text(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return fmt::format("{} degrees about ({}, {}, {})", turn.angle() * 180 / EIGEN_PI, turn.axis().x(), turn.axis().y(),
                     turn.axis().z());
}

// What was taken of the file, in its own coordinates.
void record_selection(const Selection& selection, size_t removed, const GaussianNotes& notes, Provenance& provenance) {
  if (!notes.offset.isZero()) {
    provenance.options.emplace_back("offset",
                                    fmt::format("{} {} {}", notes.offset.x(), notes.offset.y(), notes.offset.z()));
  }
  if (notes.dropped > 0) provenance.options.emplace_back("gaussians_dropped", std::to_string(notes.dropped));
  if (selection.opacity_threshold > 0) {
    provenance.options.emplace_back("opacity_threshold", fmt::format("{}", selection.opacity_threshold));
  }
  if (selection.crop) {
    const Eigen::Vector3d &low = selection.crop->min(), &high = selection.crop->max();
    provenance.options.emplace_back(
        "crop", fmt::format("{} {} {} {} {} {}", low.x(), high.x(), low.y(), high.y(), low.z(), high.z()));
  }
  if (removed > 0) provenance.options.emplace_back("gaussians_removed", std::to_string(removed));
}

// A field in other coordinates than the Gaussians' would give its numbers to nobody, or to the wrong ones.
void require_overlap(const MaterialField& field, const Gaussians& gaussians, const ImportOptions& options) {
  Eigen::AlignedBox3f samples, scene;
  for (const Eigen::Vector3f& p : field.position) samples.extend(p);
  for (const Eigen::Vector3f& p : gaussians.position) scene.extend(p);
  const float margin = 0.1f * scene.diagonal().norm();
  const Eigen::AlignedBox3f around(scene.min().array() - margin, scene.max().array() + margin);
  if (around.intersects(samples)) return;
  const auto text = [](const Eigen::AlignedBox3f& box) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g})", box.min().x(), box.min().y(),
                       box.min().z(), box.max().x(), box.max().y(), box.max().z());
  };
  throw invalid_input({options.material_field, "positions", text(samples), text(scene) + ", where the Gaussians are",
                       "write the positions in the coordinates of " + options.gaussians});
}

// A plane that has a part of the scene behind it: what lies there would be pushed out at once.
std::string cut_warning(const Gaussians& gaussians, const RunSpecification& run) {
  constexpr double kWorthAWarning = 0.02;
  const SolverMap map = solver_map(gaussians, run);
  for (size_t k = 0; k < run.colliders.size(); ++k) {
    const RunSpecification::Collider& c = run.colliders[k];
    if (c.type != RunSpecification::Collider::Type::plane) continue;
    size_t behind = 0;
    for (const Eigen::Vector3f& p : gaussians.position) {
      behind += c.normal.dot(map.to_solver(p.cast<double>()) - c.point) < -0.5 * run.grid.dx();
    }
    const double share = static_cast<double>(behind) / static_cast<double>(gaussians.size());
    if (share < kWorthAWarning) continue;
    return fmt::format(
        "colliders/{}: the plane at ({:.3g}, {:.3g}, {:.3g}) goes through the scene, {:.0f} % of whose Gaussians lie "
        "behind "
        "it; move it, or the scene with placement.center",
        k, c.point.x(), c.point.y(), c.point.z(), 100 * share);
  }
  return "";
}

// What makes the scene so large that little is left of the object in the solver; empty where nothing does. Where much
// lies far around the object, a crop of floaters alone would not help.
std::string size_warning(const Gaussians& gaussians, const GaussianNotes& notes) {
  constexpr double kLeft = 3;  // the longest side without floaters, over the object's
  const Floaters floaters = find_floaters(gaussians);
  const DenseComponent object = dense_component(gaussians);
  const std::string warning = floater_warning(floaters, notes.offset);
  if (!warning.empty() && !(floaters.box.sizes().maxCoeff() > kLeft * object.box.sizes().maxCoeff())) return warning;
  const std::string around = surroundings_warning(gaussians, object, notes.offset);
  return around.empty() ? warning : around;
}

// Removes what is not selected; the crop of the user's is in the file's coordinates, and becomes one of the scene's.
size_t take_selected(Gaussians& gaussians, ImportOptions& options, const GaussianNotes& notes) {
  Selection& selection = options.selection;
  if (selection.crop_dense) {
    Selection opaque;
    opaque.opacity_threshold = selection.opacity_threshold;
    const size_t before = gaussians.size();
    select_gaussians(gaussians, opaque, options.gaussians);
    const DenseComponent object = dense_component(gaussians);
    selection.crop = object.box;
    selection.crop_axes = Eigen::Matrix3d::Identity();
    select_gaussians(gaussians, selection, options.gaussians);
    log_note(fmt::format("{}: --crop auto takes {} of {} Gaussians: --crop {}", options.gaussians, gaussians.size(),
                         before, crop_text(Eigen::AlignedBox3d(object.box).translate(notes.offset))));
    selection.crop->translate(notes.offset);
    return before - gaussians.size();
  }
  Selection here = selection;
  if (here.crop) here.crop->translate(-(here.crop_axes * notes.offset));
  return select_gaussians(gaussians, here, options.gaussians);
}

}  // namespace

void write_import_bundle(const ImportOptions& given) {
  ImportOptions options = given;
  check_prompt(options.prompt, "--prompt");
  if (options.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string::npos ||
      options.name.size() > kMaxName) {
    throw Error(ExitCode::usage, "--name: found \"" + one_line(options.name, 80) +
                                     "\", expected an id [a-z0-9-] of at most 64 characters");
  }
  PhysGaussianImport configuration;
  Json base = Json::object();
  if (!options.physgaussian.empty()) {
    configuration = load_physgaussian(options.physgaussian);
    base = take_configuration(configuration, options);
  }
  options.dataparser = dataparser_file(options);
  MaterialSamples samples;
  if (!options.material_field.empty()) samples = load_material_samples(options.material_field);
  GaussianFile file = read_gaussian_file(options.gaussians, options.reading);
  const GaussianNotes& notes = file.notes;
  for (const std::string& note : notes.notes) log_note(options.gaussians + ": " + note);
  for (const std::string& warning : notes.warnings) log_warning(options.gaussians + ": " + warning);
  if (options.up.empty()) options.up = usual_up(options, notes);
  Gaussians gaussians = std::move(file.gaussians);
  const size_t removed = take_selected(gaussians, options, notes);
  std::string warning = size_warning(gaussians, notes);
  const bool turned = configuration.turn != Eigen::Matrix3d::Identity();
  if (turned) splat::turn_gaussians(gaussians, configuration.turn);
  MaterialField field;
  if (!options.material_field.empty()) {
    field = placed_samples(samples, notes.offset, configuration.turn);
    require_overlap(field, gaussians, options);
  }
  Scene scene;
  scene.name = options.name.empty() ? name_from(options.gaussians) : options.name;
  scene.prompt = options.prompt;
  scene.run = run_for(options, std::move(base), gaussians);
  scene.gaussians = options.folder + "/gaussians.ply";

  std::vector<Eigen::Vector3d> means = robust_means_of(gaussians);
  std::vector<CopiedFile> copies;
  std::vector<Image> rendered;
  std::vector<std::pair<std::string, std::string>> chosen;
  double front = 0;
  if (!options.cameras.empty()) {
    DataparserTransform placing;
    placing.rotation = configuration.turn;
    placing.translation = -(configuration.turn * notes.offset);
    UserViews user = read_user_views(options.cameras, options.views, options.dataparser, placing, means, options.up,
                                     options.front, options.folder);
    if (!given.dataparser.empty() && given.dataparser != "none" && !user.transformed) {
      throw Error(ExitCode::usage, "--dataparser-transforms: found " + options.cameras +
                                       ", whose cameras are in the coordinates of the Gaussians, expected a file of "
                                       "another program");
    }
    if (!user.transformed) options.dataparser.clear();
    scene.views = std::move(user.views);
    copies = std::move(user.files);
    chosen = std::move(user.chosen);
    front = user.front;
  } else {
    front = front_without_views(options);
    const std::vector<Camera> cameras =
        view_cameras(means, options.view_elevation, {options.up, kViewFov, kViewMargin, kViewSize, kViewSize, front});
    for (size_t i = 0; i < cameras.size(); ++i)
      scene.views.push_back({kViewNames[i], options.folder + "/views/" + kViewNames[i] + ".png", cameras[i]});
  }
  // Rendering a large scene takes the most memory: the means are no longer held then.
  scene.output_cameras = {
      frame_points(points_to_frame(std::move(means), gaussians, scene.run), {options.azimuth, options.elevation},
                   {options.up, kOutputFov, kOutputMargin, scene.run.render.width, scene.run.render.height, front})};
  if (options.cameras.empty()) {
    std::vector<Camera> cameras;
    for (const SceneView& view : scene.views) cameras.push_back(view.camera);
    rendered = render_view_images(gaussians, cameras, scene.run.render);
  }

  Provenance provenance;
  provenance.tool = "pm-scene";
  provenance.options = {{"command", "import"}, {"up", options.up}};
  if (!options.front.empty()) provenance.options.emplace_back("front", options.front);
  record_selection(options.selection, removed, notes, provenance);
  for (const std::string& note : notes.notes) provenance.options.emplace_back("file", note);
  if (turned) provenance.options.emplace_back("turned", rotation_text(configuration.turn));
  for (const auto& [name, image] : chosen) provenance.options.emplace_back("view " + name, image);
  for (const Omission& field : configuration.not_mapped) {
    provenance.options.emplace_back("not mapped " + field.what, field.why);
  }
  for (const std::string& input : gaussian_input_files(options.gaussians)) provenance.add_input(input);
  if (!options.physgaussian.empty()) provenance.add_input(options.physgaussian);
  if (!options.run.empty()) provenance.add_input(options.run);
  if (!options.material_field.empty()) provenance.add_input(options.material_field);
  if (!options.cameras.empty()) {
    for (const std::string& file : captured_view_files(options.cameras)) provenance.add_input(file);
  }
  if (!options.dataparser.empty()) provenance.add_input(options.dataparser);
  std::vector<std::string> row_keys;
  if (!options.inventory.empty()) {
    const Inventory inventory = load_inventory(options.inventory);
    std::vector<std::string> views;
    for (const SceneView& view : scene.views) views.push_back(view.name);
    require_known_names(inventory, views, options.inventory);
    row_keys = inventory.row_keys();
    provenance.add_input(options.inventory);
    scene.inventory = options.folder + "/inventory.json";
    copies.push_back({scene.inventory, read_file(options.inventory)});
  }
  std::vector<CopiedFile> masks;
  if (!options.masks.empty()) {
    masks = read_masks(options, scene.views);
    scene.masks = options.folder + "/masks";
  }

  save_gaussians_ply(scene.gaussians, gaussians);
  for (size_t i = 0; i < rendered.size(); ++i) save_png(scene.views[i].image, rendered[i]);
  for (const CopiedFile& file : copies) write_file(file.to, file.bytes);
  for (const CopiedFile& file : masks) write_file(file.to, file.bytes);
  if (!masks.empty()) remove_other_masks(scene.masks, masks);
  if (!options.physgaussian.empty()) {
    Provenance hints;
    hints.tool = "pm-scene";
    hints.add_input(options.physgaussian);
    scene.materials = options.folder + "/material-records.json";
    save_record(scene.materials, "material_records", hints, material_hints(configuration, row_keys));
  }
  if (!options.material_field.empty()) {
    Provenance of_field;
    of_field.tool = "pm-scene";
    of_field.add_input(options.material_field);
    scene.material_field = options.folder + "/material-field.h5";
    save_material_field(scene.material_field, field, of_field);
  }
  save_scene(options.folder + "/scene.json", scene, provenance);
  if (turned) print("turned: the bundle has PhysGaussian's axes, {}\n", rotation_text(configuration.turn));
  for (const Omission& field : configuration.not_mapped) print("not mapped: {}: {}\n", field.what, field.why);
  const std::string doubt = scene_doubt(gaussians, rendered);
  for (const std::string& text : {doubt, warning, cut_warning(gaussians, scene.run)}) {
    if (!text.empty()) log_warning(options.gaussians + ": " + text);
  }
  const size_t simulated = scene.run.particles.simulated(gaussians.size());
  if (simulated < gaussians.size()) {
    log_warning(
        fmt::format("{}: {} Gaussians are more than particles.max = {}: {} of them are simulated and carry the "
                    "others",
                    options.gaussians, gaussians.size(), scene.run.particles.max, simulated));
  }
  log_info(fmt::format("{}: {} Gaussians", options.folder, gaussians.size()));
}

}  // namespace physmas::bundle
