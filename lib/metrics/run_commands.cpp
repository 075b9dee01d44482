// pm-eval motion, silhouettes and labels: what reads our own runs.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "base/error.h"
#include "base/output.h"
#include "metrics/commands.h"
#include "metrics/gaussian_tracks.h"
#include "metrics/label_accuracy.h"
#include "records/execution.h"
#include "records/truth.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"

namespace physmas::metrics {
namespace {

struct RunOptions {
  std::string scene, inventory, state, rollout, reference, target, out;
};

void add_run_options(Command command, RunOptions& options, const char* rollout) {
  command.add_option("--scene", options.scene, "Scene with the Gaussians and output cameras").required();
  command.add_option("--inventory", options.inventory, "Objects and parts").required();
  command.add_option("--state", options.state, "Labels and the solver map").required();
  command.add_option("--rollout", options.rollout, rollout).required();
  command.add_option("--target", options.target, "Object id or row key; the whole scene by default");
}

// The rollout is the one that its record names. One without a record, as other programs write them, is taken; and of
// another state of the same Gaussians, too: a method is measured with the labels of the reference.
void check_rollout(const std::string& rollout) {
  std::error_code failure;
  if (std::filesystem::exists(execution_path_of(rollout), failure)) load_execution_of(rollout);
}

// What the rollouts of one state share.
struct Run {
  explicit Run(const RunOptions& options)
      : scene(load_scene(options.scene, needs())),
        inventory(load_inventory(options.inventory)),
        state(load_state(options.state, &inventory)),
        gaussians(load_labelled_gaussians(scene.gaussians, state, options.state)),
        target(target_gaussians(inventory, state, options.target)) {
    require_made_from(options.state, options.inventory, false, "state");
    check_rollout(options.rollout);
    if (!options.reference.empty()) check_rollout(options.reference);
  }
  static SceneNeeds needs() {
    SceneNeeds needs;
    needs.gaussians = needs.output_cameras = true;
    return needs;
  }

  Scene scene;
  Inventory inventory;
  State state;
  Gaussians gaussians;
  std::vector<uint8_t> target;
};

int motion(const RunOptions& options) {
  const Run run(options);
  const splat::RolloutFrames rollout(options.rollout, run.state);
  const splat::RolloutFrames reference(options.reference, run.state);
  const std::vector<int> queries = choose_queries(run.scene, run.gaussians, reference, run.target);
  const TargetMotion expected = track_target(run.scene, run.gaussians, reference, run.target, queries);
  const TargetMotion measured = track_target(run.scene, run.gaussians, rollout, run.target, queries);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "motion"},
                        {"tracks", "projected Gaussians"},
                        {"visibility", kExactVisibility},
                        {"target", options.target}};
  for (const std::string& input : {options.scene, options.inventory, options.state, options.rollout, options.reference})
    provenance.add_input(input);
  report_motion(options.out, options.target.empty() ? "scene" : options.target,
                trajectory_nrmse(expected.tracks, measured.tracks), area_log_rmse(expected.areas, measured.areas),
                strain_rmse(expected.tracks, measured.tracks), provenance);
  return 0;
}

int silhouettes(const RunOptions& options) {
  const Run run(options);
  const splat::RolloutFrames rollout(options.rollout, run.state);
  const std::vector<Image> masks = target_silhouettes(run.scene, run.gaussians, rollout, run.target);
  for (size_t t = 0; t < masks.size(); ++t) save_png(fmt::format("{}/{:05}.png", options.out, t), masks[t]);
  return 0;
}

struct LabelOptions {
  std::string scene, inventory, state, out;
};

int labels(const LabelOptions& options) {
  const Scene scene = load_scene(options.scene, SceneNeeds());
  if (scene.inventory.empty())
    throw invalid_input({options.scene, "/inventory", "none", "the inventory of a scene that pm-scene synthesised"});
  const std::string truth_file = scene.root + "/truth.h5";
  const Inventory truth_inventory = load_inventory(scene.inventory), inventory = load_inventory(options.inventory);
  const State state = load_state(options.state, &inventory);
  require_made_from(options.state, options.inventory, false, "state");
  const std::vector<int32_t> truth = load_truth(truth_file, truth_inventory, state.gaussian_count());
  const LabelAccuracy accuracy = compare_labels(truth_inventory, truth, inventory, state.gaussian_row);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "labels"}};
  for (const std::string& input : {truth_file, scene.inventory, options.inventory, options.state})
    provenance.add_input(input);
  save_label_accuracy(options.out, accuracy, provenance);
  print("{}", label_table(accuracy));
  return 0;
}

}  // namespace

Subcommand add_motion_command(Command app) {
  const auto options = std::make_shared<RunOptions>();
  Command command =
      app.add_subcommand("motion", "Trajectory, area and strain errors against a reference rollout of the same state");
  add_run_options(command, *options, "Rollout to measure");
  command.add_option("--reference", options->reference, "Rollout to measure against").required();
  command.add_option("--out", options->out, "Metrics to write").required();
  return {command, [options](const CommonOptions&) { return motion(*options); }};
}

Subcommand add_silhouettes_command(Command app) {
  const auto options = std::make_shared<RunOptions>();
  Command command = app.add_subcommand("silhouettes", "Target masks of a rollout, one PNG per frame");
  add_run_options(command, *options, "Rollout to draw");
  command.add_option("--out", options->out, "Folder for the masks").required();
  return {command, [options](const CommonOptions&) { return silhouettes(*options); }};
}

Subcommand add_labels_command(Command app) {
  const auto options = std::make_shared<LabelOptions>();
  Command command =
      app.add_subcommand("labels", "Row labels of a synthesised scene against its truth, with a confusion table");
  command.add_option("--scene", options->scene, "scene.json of the bundle, with truth.h5 beside it").required();
  command.add_option("--inventory", options->inventory, "inventory.json of pm-ground").required();
  command.add_option("--state", options->state, "state.h5 of pm-lift").required();
  command.add_option("--out", options->out, "Record to write (JSON)").required();
  return {command, [options](const CommonOptions&) { return labels(*options); }};
}

}  // namespace physmas::metrics
