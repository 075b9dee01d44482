// pm-lift: masks to Gaussians to particles. Inventory, masks and 3D Gaussians in; the initial state out.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/error.h"
#include "base/log.h"
#include "lift/assignment.h"
#include "lift/initial_state.h"
#include "lift/islands.h"
#include "lift/label_picture.h"
#include "lift/material_samples.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/material_field.h"
#include "records/scene.h"
#include "records/state.h"
#include "records/truth.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "scene/placement.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, inventory, masks, labels, out, labels_png;
};

// The camera of every view; masks must have its size.
std::vector<Camera> cameras_of(const Scene& scene, const std::vector<ViewMasks>& views, const std::string& file) {
  std::vector<Camera> cameras;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const Camera& camera = scene.views[v].camera;
    const auto check = [&](const Mask& mask) {
      if (mask.empty() || (mask.width == camera.width && mask.height == camera.height)) return;
      throw invalid_input({file, "/views/" + scene.views[v].name,
                           fmt::format("a mask of {} x {}", mask.width, mask.height),
                           fmt::format("{} x {}, the size of the view's camera", camera.width, camera.height)});
    };
    for (const Mask& mask : views[v].objects) check(mask);
    for (const Mask& mask : views[v].rows) check(mask);
    cameras.push_back(camera);
  }
  return cameras;
}

void check_residual_rows(const Inventory& inventory, const std::string& file) {
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    if (lift::residual_row_of(inventory, static_cast<int>(o)) < 0) {
      throw invalid_input({file, "/rows", "no residual row of object \"" + inventory.objects[o].id + "\"", "one",
                           "let pm-ground write the inventory"});
    }
  }
}

// By the masks of the views. What became of islands is added to `omitted`.
lift::Labels assigned_labels(const Scene& scene, const Inventory& inventory, const Gaussians& gaussians,
                             const std::vector<ViewMasks>& masks, const std::vector<Camera>& cameras,
                             std::vector<Omission>& omitted) {
  lift::Labels labels = lift::assign_rows({gaussians, cameras, masks, inventory, scene.run.lifting.occlusion});
  log_info(fmt::format("{} Gaussians in no view, {} hidden, {} object and {} part votes, {} rescued, {} residual",
                       labels.counts.unseen, labels.counts.hidden, labels.counts.object_votes, labels.counts.part_votes,
                       labels.counts.rescued, labels.counts.residual));
  for (const size_t v : labels.agreement.contradicted) {
    omitted.push_back({"masks of " + masks[v].view, "they contradict those of the other views"});
    log_warning("the masks of the view " + masks[v].view + " contradict those of the other views; they do not count");
  }
  for (const auto& [v, w] : labels.agreement.undecided) {
    omitted.push_back({"masks of " + masks[v].view + " and " + masks[w].view, "they contradict each other"});
    log_warning(fmt::format("the masks of the views {} and {} contradict each other; the labels may be wrong",
                            masks[v].view, masks[w].view));
  }
  if (scene.run.lifting.islands == RunSpecification::Lifting::Islands::keep) return labels;
  const double cell = scene.run.grid.dx() / solver_map(gaussians, scene.run).s;
  const lift::Islands islands = lift::join_islands(gaussians, inventory, cell, labels);
  omitted.insert(omitted.end(), islands.omitted.begin(), islands.omitted.end());
  if (!islands.omitted.empty()) {
    log_warning(fmt::format(
        "small pieces hang apart from their rows; given to what they touch: {} Gaussians ({} pieces); left, as they "
        "touch nothing: {} ({}); the state names the rows",
        islands.given, islands.given_pieces, islands.apart, islands.apart_pieces));
  }
  return labels;
}

// As a file says.
lift::Labels given_labels(const Options& options, const Inventory& inventory, size_t count) {
  lift::Labels labels;
  labels.row = load_truth(options.labels, inventory, count);
  for (const int32_t r : labels.row) labels.object.push_back(inventory.object_of_row(r));
  labels.confidence.assign(count, 1);
  return labels;
}

// How many particles have a sample; those without are named in the state.
void report_samples(State& state) {
  constexpr double kManyWithout = 0.05;
  const size_t without = static_cast<size_t>(std::count(state.field.E.begin(), state.field.E.end(), 0.f));
  if (without == 0) return;
  const std::string text = fmt::format("{} of {} particles have no sample within {:.3g} (scene units)", without,
                                       state.particle_count(), state.field.reach / state.map.s);
  state.omitted.push_back({"the material field at some particles", text + ": they have their rows' materials"});
  if (static_cast<double>(without) > kManyWithout * static_cast<double>(state.particle_count()))
    log_warning("material field: " + text +
                " and take their rows' materials; lifting.field_reach says how far it reaches");
}

int lift_scene(const Options& options) {
  const Stopwatch watch;
  const Scene scene = load_scene(options.scene, {false, true, true, false});
  const Inventory inventory = load_inventory(options.inventory);
  std::vector<std::string> names;
  for (const SceneView& view : scene.views) names.push_back(view.name);
  std::vector<ViewMasks> masks(names.size());
  if (options.labels.empty()) {
    check_residual_rows(inventory, options.inventory);
    require_written_with(options.inventory, options.masks);
    masks = load_masks(options.masks, inventory, names);
  }
  const std::vector<Camera> cameras = cameras_of(scene, masks, options.masks);
  const Gaussians gaussians = load_gaussians(scene.gaussians);
  if (gaussians.size() == 0) throw invalid_input({scene.gaussians, "", "no Gaussians", "at least one"});
  log_info(fmt::format("read {} Gaussians after {:.2f} s", gaussians.size(), watch.seconds()));

  std::vector<Omission> omitted;
  const lift::Labels labels = options.labels.empty()
                                  ? assigned_labels(scene, inventory, gaussians, masks, cameras, omitted)
                                  : given_labels(options, inventory, gaussians.size());
  log_info(fmt::format("rows after {:.2f} s", watch.seconds()));
  State state = lift::initial_state(gaussians, labels, inventory, scene.run, scene.gaussians);
  state.omitted.insert(state.omitted.end(), omitted.begin(), omitted.end());
  if (!scene.material_field.empty()) {
    state.field =
        lift::sample_particles(load_material_field(scene.material_field), state, scene.run, scene.material_field);
    report_samples(state);
  }
  log_info(fmt::format("{} particles after {:.2f} s", state.particle_count(), watch.seconds()));
  for (const Omission& omission : state.omitted) log_info(omission.what + ": " + omission.why);

  Provenance provenance;
  provenance.tool = "pm-lift";
  for (const std::string& input :
       {options.scene, scene.gaussians, options.inventory, options.labels.empty() ? options.masks : options.labels})
    provenance.add_input(input);
  if (!scene.material_field.empty()) provenance.add_input(scene.material_field);
  save_state(options.out, state, provenance);
  if (!options.labels_png.empty()) {
    std::vector<bool> residual;
    for (const InventoryRow& row : inventory.rows) residual.push_back(row.residual);
    for (size_t v = 0; v < cameras.size(); ++v) {
      const std::filesystem::path file = std::filesystem::path(options.labels_png) / (names[v] + ".png");
      save_png(file.string(), lift::label_picture(gaussians, labels.row, residual, cameras[v]));
    }
  }
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  ToolMain tool;
  tool.name = "pm-lift";
  tool.description = "Give every Gaussian one row by the masks of the four views, and fill the objects with particles.";
  tool.footer =
      "Example: pm-lift --scene bundle/scene.json --inventory run/inventory.json --masks run/masks.h5 --out "
      "run/state.h5\n"
      "Reads scene.json (or its slice), the Gaussians, inventory.json and masks.h5 (or truth.h5); writes state.h5.";
  tool.options = [&](Command app) {
    app.add_option("--scene", options.scene, "Scene bundle, or its slice for this stage").required();
    app.add_option("--inventory", options.inventory, "inventory.json of pm-ground").required();
    auto how = app.add_option_group("labels", "Where the rows come from").require_option(1);
    how.add_option("--masks", options.masks, "masks.h5 of pm-ground");
    how.add_option("--labels", options.labels,
                   "The row of every Gaussian, as in truth.h5 of a synthesised bundle: nothing is lifted");
    app.add_option("--out", options.out, "The state to write").required();
    app.add_option("--labels-png", options.labels_png, "Also draw the rows of all views into this folder");
  };
  tool.work = [&](const CommonOptions&) { return lift_scene(options); };
  return run_tool(argc, argv, tool);
}
