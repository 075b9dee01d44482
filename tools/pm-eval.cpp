// pm-eval: measure finished runs, and the solver.
#include <fmt/format.h>

#include <mutex>
#include <thread>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/log.h"
#include "candidate/timestep.h"
#include "eval/accuracy_report.h"
#include "eval/commands.h"
#include "eval/gaussian_tracks.h"
#include "eval/label_accuracy.h"
#include "eval/stability_report.h"
#include "eval/verification.h"
#include "records/inventory.h"
#include "scene/gaussian_files.h"

using namespace physmas;

namespace {

struct Options {
  std::string scene, inventory, state, rollout, reference, target, out;
};

int motion(const Options& options) {
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  const Inventory inventory = load_inventory(options.inventory);
  const State state = load_state(options.state, &inventory);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  const std::vector<uint8_t> target = eval::target_gaussians(inventory, state, options.target);
  const RolloutReader rollout(options.rollout, gaussians.size()), reference(options.reference, gaussians.size());
  const std::vector<int> queries = eval::choose_queries(scene, gaussians, state, reference, target);
  const eval::TargetMotion expected = eval::track_target(scene, gaussians, state, reference, target, queries);
  const eval::TargetMotion measured = eval::track_target(scene, gaussians, state, rollout, target, queries);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "motion"}, {"target", options.target}};
  for (const std::string& input : {options.scene, options.inventory, options.state, options.rollout, options.reference})
    provenance.add_input(input);
  eval::report_motion(options.out, options.target.empty() ? "scene" : options.target,
                      eval::trajectory_nrmse(expected.tracks, measured.tracks),
                      eval::area_log_rmse(expected.areas, measured.areas),
                      eval::strain_rmse(expected.tracks, measured.tracks), provenance);
  return 0;
}

// The step that pm-candidates records for rows of these materials, with the fallback of the whole-object row.
double paper_step(const std::vector<mpm::Material>& materials) {
  std::vector<CandidateRow> rows;
  for (const mpm::Material& m : materials) {
    CandidateRow row;
    row.branch = m.branch;
    row.E = m.E, row.nu = m.nu, row.rho = m.rho;
    rows.push_back(row);
  }
  return candidate::step_size(rows, WholeObject{}, RunSpecification::Time{}).dt;
}

struct AccuracyOptions {
  std::string out, only;
  bool quick = false;
};

int accuracy(const AccuracyOptions& options, int threads) {
  if (threads <= 0) threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const eval::AccuracyPlan plan = eval::accuracy_plan(options.quick, threads, paper_step);
  std::vector<eval::AccuracyCase> cases;
  std::string known;
  for (eval::AccuracyCase& c : eval::accuracy_cases(plan.spacing)) {
    known += (known.empty() ? "" : ", ") + c.name;
    if (options.only.empty() || c.name == options.only) cases.push_back(std::move(c));
  }
  if (cases.empty())
    throw Error(ExitCode::usage, fmt::format("--case: found \"{}\", expected one of {}", options.only, known));
  Progress progress("setting", static_cast<long>(cases.size() * (plan.settings.size() + 2)));
  long done = 0;
  std::vector<eval::AccuracyStudy> studies;
  for (const eval::AccuracyCase& c : cases)
    studies.push_back(eval::run_accuracy(c, plan, threads, [&] { progress.update(++done); }));
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {
      {"metric", "accuracy"}, {"quick", options.quick ? "yes" : "no"}, {"threads", std::to_string(threads)}};
  if (!options.only.empty()) provenance.options.emplace_back("case", options.only);
  const std::string command =
      fmt::format("pm-eval accuracy --out DIR{}{} --threads {}", options.quick ? " --quick" : "",
                  options.only.empty() ? "" : " --case " + options.only, threads);
  eval::write_accuracy(options.out, studies, plan, command, provenance);
  fmt::print("{}", eval::accuracy_table(studies));
  return 0;
}

CLI::App* add_accuracy(CLI::App& app, AccuracyOptions& options) {
  CLI::App* command =
      app.add_subcommand("accuracy", "Error of the solver against run time over grid, step, precision and threads");
  command->add_option("--out", options.out, "Folder for accuracy.json, accuracy.csv and the plots")->required();
  command->add_option("--case", options.only, "Only this case");
  command->add_flag("--quick", options.quick, "Coarse grids, few steps, one repeat: a few seconds");
  return command;
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

struct StabilityOptions {
  std::string out;
  bool quick = false;
};

int stability(const StabilityOptions& options, int threads) {
  const Stopwatch watch;
  const std::vector<eval::StabilityCase> cases = eval::stability_cases(options.quick);
  Progress bar("case", static_cast<long>(cases.size()));
  std::mutex one_at_a_time;
  const std::vector<eval::StabilityRun> runs = eval::run_stability(cases, paper_step, threads, [&](long done, long) {
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    bar.update(done);
  });
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "stability"}, {"cases", options.quick ? "quick" : "all"}};
  eval::write_stability(options.out, runs, paper_step, watch.seconds(), provenance);
  fmt::print("{:<11} {:<6} {:<7} {:>6} {:>7} {:>9} {:>8} {:>17}\n", "study", "rule", "", "runs", "stable", "diverged",
             "garbage", "latest detection");
  long bad = 0;
  for (const eval::StabilityCount& c : eval::count_stability(runs)) {
    fmt::print("{:<11} {:<6} {:<7} {:>6} {:>7} {:>9} {:>8} {:>17}\n", c.study, c.rule, c.precision, c.runs, c.stable,
               c.diverged, c.garbage, c.latest);
    bad += c.garbage + (c.rule == "cfl" ? c.diverged : 0);
  }
  if (bad == 0) return 0;
  log_error(fmt::format("{} runs are garbage, or diverged with steps by cfl; see {}/stability.csv", bad, options.out));
  return static_cast<int>(ExitCode::internal);
}

CLI::App* add_stability(CLI::App& app, StabilityOptions& options) {
  CLI::App* command =
      app.add_subcommand("stability", "Sweep the solver over stiff and extreme input with both step rules");
  command->add_option("--out", options.out, "Folder for stability.json, stability.csv and heat maps")->required();
  command->add_flag("--quick", options.quick, "Some dozens of cases instead of all");
  return command;
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
  const std::vector<int32_t> truth = eval::load_truth(truth_file, truth_inventory, state.gaussian_count());
  const eval::LabelAccuracy accuracy = eval::compare_labels(truth_inventory, truth, inventory, state.gaussian_row);
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "labels"}};
  for (const std::string& input : {truth_file, scene.inventory, options.inventory, options.state})
    provenance.add_input(input);
  eval::save_label_accuracy(options.out, accuracy, provenance);
  fmt::print("{}", eval::label_table(accuracy));
  return 0;
}

CLI::App* add_labels(CLI::App& app, LabelOptions& options) {
  CLI::App* command =
      app.add_subcommand("labels", "Row labels of a synthesised scene against its truth, with a confusion table");
  command->add_option("--scene", options.scene, "scene.json of the bundle, with truth.h5 beside it")->required();
  command->add_option("--inventory", options.inventory, "inventory.json of pm-ground")->required();
  command->add_option("--state", options.state, "state.h5 of pm-lift")->required();
  command->add_option("--out", options.out, "Record to write (JSON)")->required();
  return command;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  VerificationOptions verification_options;
  AccuracyOptions accuracy_options;
  StabilityOptions stability_options;
  LabelOptions label_options;
  CLI::App* label_command = nullptr;
  std::vector<eval::Command> commands;
  CLI::App *verification_command = nullptr, *accuracy_command = nullptr, *stability_command = nullptr;
  return run_tool(
      argc, argv,
      {"pm-eval", "Measure finished runs.",
       "Example: pm-eval motion --scene scene.json --inventory inventory.json --state state.h5 --rollout rollouts/a.h5 "
       "--reference rollouts/b.h5 --out metrics.json\n"
       "         pm-eval accuracy --out accuracy; pm-eval verification --out verification.json\n"
       "         pm-eval stability --out stability\n"
       "         pm-eval aggregate --manifest evaluation.json --upr upr.json --out tables\n"
       "Reads physmas/scene/1, inventory/1, state/1, rollout/1, metrics/1, evaluation/1, study/1, answers/1, upr/1;\n"
       "writes physmas/metrics/1, study/1, upr/1, verification/1, accuracy/1, stability/1.",
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
         accuracy_command = add_accuracy(app, accuracy_options);
         stability_command = add_stability(app, stability_options);
         label_command = add_labels(app, label_options);
         for (const auto add : {eval::add_tracks_command, eval::add_flow_command, eval::add_tracker_command,
                                eval::add_silhouettes_command, eval::add_clip_command, eval::add_study_command,
                                eval::add_upr_command, eval::add_aggregate_command, eval::add_suite_command,
                                eval::add_collect_command})
           commands.push_back(add(app));
         app.require_subcommand(1);
       },
       [&](const CommonOptions& common) {
         for (const eval::Command& command : commands) {
           if (command.app->parsed()) return command.work(common);
         }
         if (label_command->parsed()) return labels(label_options);
         if (accuracy_command->parsed()) return accuracy(accuracy_options, common.threads);
         if (verification_command->parsed()) return verification(verification_options);
         if (stability_command->parsed()) return stability(stability_options, common.threads);
         return motion(options);
       }});
}
