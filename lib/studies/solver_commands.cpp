// pm-eval accuracy, verification and stability: studies of the solver.
#include <fmt/format.h>

#include <memory>
#include <mutex>
#include <thread>

#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "base/output.h"
#include "records/json.h"
#include "studies/accuracy_report.h"
#include "studies/commands.h"
#include "studies/stability_report.h"
#include "studies/verification.h"

namespace physmas::studies {
namespace {

struct AccuracyOptions {
  std::string out, only;
  bool quick = false;
};

int accuracy(const AccuracyOptions& options, const PaperStep& paper_step, Device device) {
  int& threads = device.threads;
  if (threads <= 0) threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const AccuracyPlan plan = accuracy_plan(options.quick, device, paper_step);
  std::vector<AccuracyCase> cases;
  std::string known;
  for (AccuracyCase& c : accuracy_cases(plan.spacing)) {
    known += (known.empty() ? "" : ", ") + c.name;
    if (options.only.empty() || c.name == options.only) cases.push_back(std::move(c));
  }
  if (cases.empty())
    throw Error(ExitCode::usage, fmt::format("--case: found \"{}\", expected one of {}", options.only, known));
  Progress progress("setting", static_cast<long>(cases.size() * (plan.settings.size() + 2)));
  long done = 0;
  std::vector<AccuracyStudy> studies;
  for (const AccuracyCase& c : cases)
    studies.push_back(run_accuracy(c, plan, device, [&] { progress.update(++done); }));
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {
      {"metric", "accuracy"}, {"quick", options.quick ? "yes" : "no"}, {"threads", std::to_string(threads)}};
  if (!options.only.empty()) provenance.options.emplace_back("case", options.only);
  const std::string command =
      fmt::format("pm-eval accuracy --out DIR{}{} --threads {}", options.quick ? " --quick" : "",
                  options.only.empty() ? "" : " --case " + options.only, threads);
  write_accuracy(options.out, studies, plan, command, provenance);
  print("{}", accuracy_table(studies));
  return 0;
}

struct VerificationOptions {
  std::string out;
  bool quick = false;
};

int verification(const VerificationOptions& options, const Device& device) {
  const std::vector<VerificationRow> rows = verify(options.quick, device);
  Json json;
  json["rows"] = Json::array();
  for (const VerificationRow& r : rows) {
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
  print("{}", verification_table(rows));
  return 0;
}

struct StabilityOptions {
  std::string out;
  bool quick = false;
};

int stability(const StabilityOptions& options, const PaperStep& paper_step, const Device& device) {
  const Stopwatch watch;
  const std::vector<StabilityCase> cases = stability_cases(options.quick);
  Progress bar("case", static_cast<long>(cases.size()));
  std::mutex one_at_a_time;
  const std::vector<StabilityRun> runs = run_stability(cases, paper_step, device, [&](long done, long) {
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    bar.update(done);
  });
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "stability"}, {"cases", options.quick ? "quick" : "all"}};
  write_stability(options.out, runs, paper_step, watch.seconds(), provenance);
  print("{:<11} {:<6} {:<7} {:>6} {:>7} {:>9} {:>8} {:>17}\n", "study", "rule", "", "runs", "stable", "diverged",
        "garbage", "latest detection");
  long bad = 0;
  for (const StabilityCount& c : count_stability(runs)) {
    print("{:<11} {:<6} {:<7} {:>6} {:>7} {:>9} {:>8} {:>17}\n", c.study, c.rule, c.precision, c.runs, c.stable,
          c.diverged, c.garbage, c.latest);
    bad += c.garbage + (c.rule == "cfl" ? c.diverged : 0);
  }
  if (bad == 0) return 0;
  log_error(fmt::format("{} runs are garbage, or diverged with steps by cfl; see {}/stability.csv", bad, options.out));
  return static_cast<int>(ExitCode::internal);
}

}  // namespace

Subcommand add_accuracy_command(Command app, const PaperStep& paper_step) {
  const auto options = std::make_shared<AccuracyOptions>();
  Command command =
      app.add_subcommand("accuracy", "Error of the solver against run time over grid, step, precision and threads");
  command.add_option("--out", options->out, "Folder for accuracy.json, accuracy.csv and the plots").required();
  command.add_option("--case", options->only, "Only this case");
  command.add_flag("--quick", options->quick, "Coarse grids, few steps, one repeat: a few seconds");
  return {command, [=](const CommonOptions& common) { return accuracy(*options, paper_step, common.device); }};
}

Subcommand add_verification_command(Command app) {
  const auto options = std::make_shared<VerificationOptions>();
  Command command = app.add_subcommand(
      "verification", "The solver against analytic answers under refinement: a table, and the same as a record");
  command.add_option("--out", options->out, "Record to write (JSON)").required();
  command.add_flag("--quick", options->quick, "Only the coarsest resolutions");
  return {command, [options](const CommonOptions& common) { return verification(*options, common.device); }};
}

Subcommand add_stability_command(Command app, const PaperStep& paper_step) {
  const auto options = std::make_shared<StabilityOptions>();
  Command command =
      app.add_subcommand("stability", "Sweep the solver over stiff and extreme input with both step rules");
  command.add_option("--out", options->out, "Folder for stability.json, stability.csv and heat maps").required();
  command.add_flag("--quick", options->quick, "Some dozens of cases instead of all");
  return {command, [=](const CommonOptions& common) { return stability(*options, paper_step, common.device); }};
}

}  // namespace physmas::studies
