// pm-lift: masks to Gaussians to particles. Inventory, masks and 3D Gaussians in; the initial state out.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/error.h"
#include "base/log.h"
#include "lift/assignment.h"
#include "lift/initial_state.h"
#include "lift/label_picture.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/state.h"
#include "scene/gaussian_files.h"
#include "scene/scene.h"
#include "splat/image_io.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, inventory, masks, out, labels_png;
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

int lift_scene(const Options& options) {
  const Stopwatch watch;
  const Scene scene = load_scene(options.scene, {false, true, true, false});
  const Inventory inventory = load_inventory(options.inventory);
  check_residual_rows(inventory, options.inventory);
  std::vector<std::string> names;
  for (const SceneView& view : scene.views) names.push_back(view.name);
  const std::vector<ViewMasks> masks = load_masks(options.masks, inventory, names);
  const std::vector<Camera> cameras = cameras_of(scene, masks, options.masks);
  const Gaussians gaussians = load_gaussians(scene.gaussians);
  if (gaussians.size() == 0) throw invalid_input({scene.gaussians, "", "no Gaussians", "at least one"});
  log_info(fmt::format("read {} Gaussians and the masks after {:.2f} s", gaussians.size(), watch.seconds()));

  const lift::Labels labels = lift::assign_rows({gaussians, cameras, masks, inventory, scene.run.lifting.occlusion});
  log_info(fmt::format(
      "rows after {:.2f} s: {} Gaussians in no view, {} hidden, {} object and {} part votes, {} rescued, {} residual",
      watch.seconds(), labels.counts.unseen, labels.counts.hidden, labels.counts.object_votes, labels.counts.part_votes,
      labels.counts.rescued, labels.counts.residual));
  const State state = lift::initial_state(gaussians, labels, inventory, scene.run, scene.gaussians);
  log_info(fmt::format("{} particles after {:.2f} s", state.particle_count(), watch.seconds()));
  for (const Omission& omission : state.omitted) log_info(omission.what + ": " + omission.why);

  Provenance provenance;
  provenance.tool = "pm-lift";
  for (const std::string& input : {options.scene, scene.gaussians, options.inventory, options.masks})
    provenance.add_input(input);
  save_state(options.out, state, provenance);
  if (!options.labels_png.empty()) {
    std::vector<bool> residual;
    for (const InventoryRow& row : inventory.rows) residual.push_back(row.residual);
    for (size_t v = 0; v < cameras.size(); ++v) {
      const std::filesystem::path file = std::filesystem::path(options.labels_png) / (names[v] + ".png");
      splat::save_png(file.string(), lift::label_picture(gaussians, labels.row, residual, cameras[v]));
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
      "Reads scene.json (or its slice), the Gaussians, inventory.json and masks.h5; writes state.h5.";
  tool.options = [&](CLI::App& app) {
    app.add_option("--scene", options.scene, "Scene bundle, or its slice for this stage")->required();
    app.add_option("--inventory", options.inventory, "inventory.json of pm-ground")->required();
    app.add_option("--masks", options.masks, "masks.h5 of pm-ground")->required();
    app.add_option("--out", options.out, "The state to write")->required();
    app.add_option("--labels-png", options.labels_png, "Also draw the rows of all views into this folder");
  };
  tool.work = [&](const CommonOptions&) { return lift_scene(options); };
  return run_tool(argc, argv, tool);
}
