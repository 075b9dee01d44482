// pm-simulate: one candidate -> rollout frames and an execution record.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/command_line.h"
#include "base/log.h"
#include "bind/achievement.h"
#include "bind/execution.h"
#include "bind/problem.h"
#include "bind/rollout.h"
#include "bind/start.h"
#include "bind/stillness.h"
#include "bind/tearing.h"
#include "bind/timing.h"
#include "bind/vector.h"
#include "mpm/device_choice.h"
#include "records/json.h"
#include "records/scene.h"

namespace fs = std::filesystem;
using namespace physmas;

namespace {

struct CliOptions {
  std::string scene, state, candidate, out;
  std::string timestep, precision = "float", energy = "frames";  // timestep: empty for the run's rule
  int grid = 0, frames = 0;
  long long max_steps = mpm::Options().max_steps;
  bool strict = false;
};

const char* device_name(const Device& device) {
  return device.kind == Device::Kind::cuda ? "cuda" : "cpu";
}

Provenance provenance_of(const CliOptions& options, const std::string& rule) {
  Provenance provenance;
  provenance.tool = "pm-simulate";
  provenance.options = {{"timestep", rule}, {"precision", options.precision}, {"energy", options.energy}};
  if (options.grid > 0) provenance.options.emplace_back("grid", std::to_string(options.grid));
  if (options.frames > 0) provenance.options.emplace_back("frames", std::to_string(options.frames));
  if (options.max_steps != mpm::Options().max_steps)
    provenance.options.emplace_back("max-steps", std::to_string(options.max_steps));
  for (const std::string& input : {options.scene, options.state, options.candidate}) provenance.add_input(input);
  return provenance;
}

// On a GPU sums are rounded otherwise.
Provenance on_device(Provenance provenance, const Device& device) {
  if (device.kind == Device::Kind::cuda) provenance.options.emplace_back("device", device_name(device));
  return provenance;
}

mpm::Options solver_options(const CliOptions& options, const CommonOptions& common, const RunSpecification& run) {
  mpm::Options solver;
  solver.precision = options.precision == "double" ? mpm::Precision::full : mpm::Precision::single;
  solver.device = common.device;
  solver.measure_energy = options.energy != "off";
  solver.measure_steps = options.energy == "steps";
  solver.track_total_F = run.transport.total;
  solver.max_steps = options.max_steps;
  solver.stiff = bind::bind_stiff_rule(run.time.stiff);
  return solver;
}

int simulate(const CliOptions& options, const CommonOptions& common) {
  RunSpecification run = load_scene(options.scene, {}).run;
  const State state = load_state(options.state);
  const Candidate candidate = load_candidate(options.candidate);
  require_made_from(options.candidate, options.state, false);
  if (options.grid > 0) run.grid.n = options.grid;
  if (options.frames > 0) run.time.frames = options.frames;

  mpm::Problem problem = bind::bind_problem(candidate, state, run, {options.state, options.candidate});
  const std::string rule = options.timestep.empty() ? run.time.rule : options.timestep;
  const Provenance provenance = provenance_of(options, rule);
  mpm::Options solver = solver_options(options, common, run);
  mpm::DeviceChoice choice =
      mpm::choose_device(problem, bind::bind_timing(rule, run.time, candidate, options.candidate).timing, solver);
  double speed = 0;  // particle-steps/s
  const std::optional<mpm::Equilibrium> start = bind::bind_start(run.time, common.device, problem);
  const auto attempt = [&](const std::string& by, const mpm::Options& solver, bool only_if_stable) {
    const bind::BoundTiming timing = bind::bind_timing(by, run.time, candidate, options.candidate);
    bind::RolloutRecorder rollout(options.out, state.carrier_count(), solver, on_device(provenance, solver.device));
    rollout.start_from(problem.particles.deformation_gradient);
    bind::AchievementMeter achievement(candidate, problem, bind::to_mpm(run.placement.up_vector()), run.time.frame_dt);
    bind::StillnessMeter stillness(candidate, problem);
    std::vector<TornRow> torn;
    Progress progress("frame", timing.timing.frames);
    const mpm::Result result = mpm::run(problem, timing.timing, solver, [&](const mpm::Frame& frame) {
      rollout.append(frame);
      achievement.observe(frame);
      stillness.observe(frame);
      if (frame.index + 1 == timing.timing.frames) torn = bind::torn_rows(candidate, problem, frame.state.x);
      progress.update(frame.index + 1);
    });
    if (!only_if_stable || result.status == mpm::Status::stable) rollout.commit();
    speed = result.particle_steps_per_second;
    ExecutionRecord record = bind::execution_record(candidate, problem, timing, solver, result);
    record.achieved = achievement.result();
    record.stillness = stillness.result();
    record.torn = torn;
    return record;
  };
  ExecutionRecord record = mpm::on_chosen_device(
      choice, common.device.automatic,
      [&](const Device& device) {
        solver.device = device;
        return attempt(rule, solver, false);
      },
      [&](const char* error) { log_warning(fmt::format("{}: {}; on the CPU instead", candidate.id, error)); });
  // An explicit --timestep is what the caller wants to see.
  if (record.diverged && record.step_rule == "paper" && options.timestep.empty() && run.time.on_divergence == "cfl") {
    log_warning(fmt::format("{}: {}; once more with time.rule=cfl", candidate.id, record.divergence->advice));
    mpm::Options retry = solver;
    retry.max_steps = std::min<long long>(retry.max_steps, run.time.retry_substeps);
    record = bind::with_retry(record, solver.max_steps, attempt("cfl", retry, true), retry.max_steps);
  }
  if (start) {
    record.start = bind::start_record(*start, state.row_keys);
    record.runtime["seconds"]["start"] = start->seconds;
  }
  record.runtime["device"] = device_name(choice.device);
  record.runtime["device_reason"] = choice.why;
  Provenance with_rollout = on_device(provenance, choice.device);
  with_rollout.add_output(options.out);
  save_execution(execution_path_of(options.out), record, with_rollout);
  for (const AchievedAction& action : record.achieved) {
    if (!action.shortfall.empty() && !record.diverged) log_warning(candidate.id + ": " + bind::shortfall_line(action));
  }
  for (const StiffRowRecord& row : record.stiff_rows) {
    if (row.rigid) log_info(fmt::format("{}: {} keeps its shape: {}", candidate.id, row.key, row.why));
  }
  for (const TornRow& row : record.torn) log_warning(candidate.id + ": " + bind::torn_line(row));
  if (record.diverged) {
    log_warning(fmt::format("{}: {}", candidate.id, record.divergence->advice));
    return static_cast<int>(options.strict ? ExitCode::diverged : ExitCode::done);
  }
  log_info(fmt::format("{}: {} frames, {} substeps of {} particles, {:.1f} million particle-steps per second",
                       candidate.id, record.frames, record.steps, record.particles, speed / 1e6));
  return static_cast<int>(ExitCode::done);
}

}  // namespace

int main(int argc, char** argv) {
  CliOptions options;
  return run_tool(
      argc, argv,
      {"pm-simulate", "Simulate one candidate with the material point method; all objects share one grid.",
       "A diverged simulation is a result: the record says so and the exit code is 0 (5 with --strict).\n"
       "Example: pm-simulate --scene scene.json --state state.h5 --candidate candidates/posterior.json --out "
       "rollouts/posterior.h5\n"
       "Reads physmas/scene/1, state/1, candidate/1; writes physmas/rollout/1 and physmas/execution/1 beside it.",
       [&](Command app) {
         app.add_option("--scene", options.scene, "Scene or its simulate slice").required();
         app.add_option("--state", options.state, "Labels and particles").required();
         app.add_option("--candidate", options.candidate, "Candidate to simulate").required();
         app.add_option("--out", options.out, "Rollout to write, .h5; the record goes beside it")
             .required()
             .check([](const std::string& path) {
               return fs::path(path).extension() == ".h5" ? std::string() : "--out: expected a name that ends in .h5";
             });
         app.add_option("--timestep", options.timestep,
                        "paper (the candidate's substeps), cfl (as small as stability asks, changing with the state), "
                        "or seconds; the run's time.rule by default")
             .group("Numerics");
         app.add_option("--max-steps", options.max_steps, "Substeps after which, or in view of which, the run ends")
             .between(1LL, 1000000000000LL)
             .capture_default_str()
             .group("Numerics");
         app.add_option("--precision", options.precision, "float or double")
             .one_of({"float", "double"})
             .capture_default_str()
             .group("Numerics");
         app.add_option("--energy", options.energy,
                        "Energy balance: off, at output frames, or the budget of all substeps (several times slower)")
             .one_of({"off", "frames", "steps"})
             .capture_default_str()
             .group("Numerics");
         app.add_option("--grid", options.grid, "Cells per axis instead of the run's")
             .between(16, 512)
             .group("Numerics");
         app.add_option("--frames", options.frames, "Output frames instead of the run's, rest frame included")
             .between(1, 10000)
             .group("Numerics");
         app.add_flag("--strict", options.strict, "Exit with 5 when the simulation diverges").group("Numerics");
       },
       [&](const CommonOptions& common) { return simulate(options, common); }, true});
}
