// pm-eval: measure finished runs.
#include <fmt/format.h>

#include "base/command_line.h"
#include "eval/gaussian_tracks.h"
#include "eval/motion.h"
#include "eval/verification.h"
#include "records/inventory.h"
#include "records/metrics.h"
#include "records/plan.h"
#include "scene/gaussian_files.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, inventory, state, rollout, reference, target, out;
};

std::vector<uint8_t> target_mask(const Inventory& inventory, const State& state, const std::string& target) {
  const std::vector<int> rows = resolve_rows(inventory, target);
  if (!target.empty() && rows.empty()) {
    std::string known;
    for (const InventoryObject& object : inventory.objects) known += (known.empty() ? "" : ", ") + object.id;
    throw Error(ExitCode::usage,
                fmt::format("--target: found \"{}\", expected an object ({}) or a row key object/part", target, known));
  }
  std::vector<uint8_t> mask(state.gaussian_count(), target.empty() ? 1 : 0);
  for (size_t i = 0; i < mask.size(); ++i) {
    for (int row : rows) {
      if (state.gaussian_row[i] == row) mask[i] = 1;
    }
  }
  return mask;
}

int motion(const Options& options) {
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  const Inventory inventory = load_inventory(options.inventory);
  const State state = load_state(options.state, &inventory);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  const std::vector<uint8_t> target = target_mask(inventory, state, options.target);
  const RolloutReader rollout(options.rollout, gaussians.size()), reference(options.reference, gaussians.size());
  const std::vector<int> queries = eval::choose_queries(scene, gaussians, state, reference, target);
  const eval::TargetMotion expected = eval::track_target(scene, gaussians, state, reference, target, queries);
  const eval::TargetMotion measured = eval::track_target(scene, gaussians, state, rollout, target, queries);
  std::vector<MetricEntry> metrics;
  const auto add = [&](const char* name, const eval::Measurement& m) {
    metrics.push_back({name, m.valid, m.value, m.samples, m.reason});
  };
  add("trajectory_nrmse", eval::trajectory_nrmse(expected.tracks, measured.tracks));
  add("area_log_rmse", eval::area_log_rmse(expected.areas, measured.areas));
  add("strain_rmse", eval::strain_rmse(expected.tracks, measured.tracks));
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "motion"}, {"target", options.target}};
  for (const std::string& input : {options.scene, options.inventory, options.state, options.rollout, options.reference})
    provenance.add_input(input);
  save_metrics(options.out, options.target.empty() ? "scene" : options.target, metrics, provenance);
  for (const MetricEntry& m : metrics)
    fmt::print("{:<18} {}\n", m.name,
               m.valid ? fmt::format("{:.4f} ({} samples)", m.value, m.samples) : "invalid: " + m.reason);
  return 0;
}

struct VerificationOptions {
  std::string out;
  bool quick = false;
};

int verification(const VerificationOptions& options) {
  const std::vector<eval::VerificationRow> rows = eval::verify(options.quick);
  Json json;
  json["rows"] = Json::array();
  for (const eval::VerificationRow& r : rows) {
    json["rows"].push_back({{"quantity", r.name},
                            {"resolution", r.resolution},
                            {"expected", r.expected},
                            {"measured", r.measured},
                            {"error", r.error()},
                            {"order", r.order != 0 ? Json(r.order) : Json()},
                            {"source", r.source}});
  }
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "verification"}, {"quick", options.quick ? "yes" : "no"}};
  save_record(options.out, "verification", provenance, json);
  fmt::print("{}", eval::verification_table(rows));
  return 0;
}

CLI::App* add_verification(CLI::App& app, VerificationOptions& options) {
  CLI::App* command = app.add_subcommand(
      "verification", "The solver against analytic answers under refinement: a table, and the same as a record");
  command->add_option("--out", options.out, "Record to write (JSON)")->required();
  command->add_flag("--quick", options.quick, "Only the coarsest resolutions");
  return command;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  VerificationOptions verification_options;
  CLI::App* verification_command = nullptr;
  return run_tool(
      argc, argv,
      {"pm-eval", "Measure finished runs.",
       "Example: pm-eval motion --scene scene.json --inventory inventory.json --state state.h5 --rollout rollouts/a.h5 "
       "--reference rollouts/b.h5 --out metrics.json\n"
       "The other evaluations of the design (clip, aggregate, upr, accuracy, stability) are not built yet.\n"
       "Reads physmas/scene/1, inventory/1, state/1, rollout/1; writes physmas/metrics/1.",
       [&](CLI::App& app) {
         CLI::App* command = app.add_subcommand(
             "motion", "Trajectory, area and strain errors against a reference rollout of the same state");
         command->add_option("--scene", options.scene, "Scene with the Gaussians and output cameras")->required();
         command->add_option("--inventory", options.inventory, "Objects and parts")->required();
         command->add_option("--state", options.state, "Labels and the solver map")->required();
         command->add_option("--rollout", options.rollout, "Rollout to measure")->required();
         command->add_option("--reference", options.reference, "Rollout to measure against")->required();
         command->add_option("--target", options.target, "Object id or row key; the whole scene by default");
         command->add_option("--out", options.out, "Metrics to write")->required();
         verification_command = add_verification(app, verification_options);
         app.require_subcommand(1);
       },
       [&](const CommonOptions&) {
         if (verification_command->parsed()) return verification(verification_options);
         return motion(options);
       }});
}
