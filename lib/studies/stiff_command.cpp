// pm-eval stiff: rigid rows against resolved runs.
#include <fmt/format.h>

#include <memory>

#include "base/error.h"
#include "base/log.h"
#include "base/output.h"
#include "records/json.h"
#include "studies/commands.h"
#include "studies/stiff_study.h"

namespace physmas::studies {
namespace {

struct StiffOptions {
  std::string out;
  StiffStudyPlan plan;
};

int stiff(const StiffOptions& options, const Device& device) {
  long cases = 0;
  std::string known;
  for (const StiffCase& c : stiff_cases(options.plan.youngs_modulus)) {
    known += (known.empty() ? "" : ", ") + c.name;
    cases += options.plan.only.empty() || c.name == options.plan.only;
  }
  if (cases == 0) {
    throw Error(ExitCode::usage, fmt::format("--case: found \"{}\", expected one of {}", options.plan.only, known));
  }
  Progress progress("case", cases);
  long done = 0;
  const std::vector<StiffStudy> studies = run_stiff_study(options.plan, device, [&] { progress.update(++done); });
  Json json = {{"youngs_modulus", options.plan.youngs_modulus},
               {"dt", options.plan.dt},
               {"impact_budget", options.plan.impact_budget},
               {"cases", Json::array()}};
  for (const StiffStudy& s : studies) {
    const StiffOutcome& o = s.rigid;
    json["cases"].push_back({{"name", s.name},
                             {"text", s.text},
                             {"held_out", s.held_out},
                             {"status", o.diverged ? "diverged" : "stable"},
                             {"stiff_error", o.stiff_error},
                             {"other_error", o.other_error},
                             {"goal_stiff", s.goal_stiff > 0 ? Json(s.goal_stiff) : Json()},
                             {"goal_other", s.goal_other > 0 ? Json(s.goal_other) : Json()},
                             {"error_bound", o.error_bound},
                             {"energy_rise", o.energy_rise},
                             {"windows", o.windows},
                             {"small_steps", o.small_steps},
                             {"impacts", o.impacts},
                             {"restitution", o.restitution < 0 ? Json() : Json(o.restitution)},
                             {"resolved_dt", s.resolved_dt},
                             {"runtime", {{"cost", o.cost}, {"resolved_cost", s.resolved_cost}}}});
  }
  Provenance provenance;
  provenance.tool = "pm-eval";
  provenance.options = {{"metric", "stiff"}, {"youngs_modulus", fmt::format("{:g}", options.plan.youngs_modulus)}};
  if (!options.plan.only.empty()) provenance.options.emplace_back("case", options.plan.only);
  save_record(options.out, "stiff", provenance, json);
  print("{}", stiff_table(studies));
  for (const StiffStudy& s : studies) {
    if (!s.rigid.diverged) continue;
    log_error(s.name + " diverged");
    return static_cast<int>(ExitCode::internal);
  }
  return 0;
}

}  // namespace

Subcommand add_stiff_command(Command app) {
  const auto options = std::make_shared<StiffOptions>();
  Command command = app.add_subcommand(
      "stiff", "Rows too stiff for the step, as bodies that keep their shape, against resolved runs: errors and costs");
  command.add_option("--out", options->out, "Record to write (JSON)").required();
  command.add_option("--case", options->plan.only, "Only this case");
  command.add_option("--youngs-modulus", options->plan.youngs_modulus, "E of the stiff rows [Pa]").between(1e8, 1e13);
  return {command, [options](const CommonOptions& common) { return stiff(*options, common.device); }};
}

}  // namespace physmas::studies
