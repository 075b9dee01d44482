// pm-simulate: one candidate -> rollout frames and an execution record.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/log.h"
#include "bind/schedule.h"
#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/execution.h"
#include "records/rollout.h"
#include "records/scene.h"
#include "records/state.h"

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

mpm::Vec3d to_mpm(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Eigen::Vector3d from_mpm(const mpm::Vec3d& v) {
  return {v.x, v.y, v.z};
}

mpm::Domain bind_domain(const RunSpecification& run) {
  mpm::Domain domain;
  domain.n = run.grid.n;
  domain.length = run.grid.length;
  domain.gravity = to_mpm(run.gravity);
  domain.wall_cells = run.walls;
  using Type = RunSpecification::Collider::Type;
  using Mode = RunSpecification::Collider::Mode;
  for (const RunSpecification::Collider& c : run.colliders) {
    mpm::Collider collider;
    collider.mode = c.mode == Mode::sticky ? mpm::Collider::Mode::sticky
                    : c.mode == Mode::slip ? mpm::Collider::Mode::slip
                                           : mpm::Collider::Mode::separate;
    collider.friction = c.friction;
    switch (c.type) {
      case Type::plane:
        collider.type = mpm::Collider::Type::plane;
        collider.center = to_mpm(c.point);
        collider.normal = to_mpm(c.normal);
        break;
      case Type::box:
        collider.type = mpm::Collider::Type::box;
        collider.center = to_mpm(0.5 * (c.min + c.max));
        collider.half_size = to_mpm(0.5 * (c.max - c.min));
        break;
      case Type::sphere:
        collider.type = mpm::Collider::Type::sphere;
        collider.center = to_mpm(c.point);
        collider.radius = c.radius;
        break;
    }
    domain.colliders.push_back(collider);
  }
  return domain;
}

mpm::ProfileConstants bind_constants(const RunSpecification::Profile& profile) {
  mpm::ProfileConstants constants;
  constants.foam_yield = profile.foam_yield;
  constants.foam_viscosity = profile.foam_viscosity;
  constants.plasticine_yield = profile.plasticine_yield;
  constants.plasticine_softening = profile.plasticine_softening;
  constants.plasticine_residual = profile.plasticine_residual;
  constants.sand_friction_angle = profile.sand_friction_angle;
  constants.drucker_prager_alpha = profile.alpha;
  constants.sand_cohesion = profile.sand_k;
  constants.snow_cohesion = profile.snow_k;
  constants.plasticine_cohesion = profile.plasticine_k;
  return constants;
}

// The paper's Bind: every particle gets the record of its row; a row with particles must be in the candidate.
std::vector<mpm::Material> bind_materials(const Candidate& candidate, const State& state, const std::string& file) {
  std::vector<mpm::Material> materials(state.row_keys.size());
  std::vector<bool> bound(state.row_keys.size(), false);
  for (size_t i = 0; i < candidate.rows.size(); ++i) {
    const CandidateRow& row = candidate.rows[i];
    const std::string pointer = fmt::format("/rows/{}", i);
    if (row.row >= static_cast<int>(state.row_keys.size()) || state.row_keys[row.row] != row.key) {
      throw invalid_field(file, pointer + "/key", row.key,
                          "the key of row " + std::to_string(row.row) + " of the state",
                          "make the candidates again with pm-candidates");
    }
    materials[row.row] = {row.branch, row.E, row.nu, row.rho};
    bound[row.row] = true;
  }
  for (int32_t r : state.row) {
    if (!bound[r])
      throw invalid_input(
          {file, "/rows", "no row \"" + state.row_keys[r] + "\"", "every row that has particles in the state"});
  }
  return materials;
}

mpm::Particles bind_particles(const State& state) {
  mpm::Particles particles;
  particles.position.reserve(state.particle_count());
  for (const Eigen::Vector3f& x : state.position) particles.position.push_back({x.x(), x.y(), x.z()});
  particles.volume.assign(state.volume.begin(), state.volume.end());
  particles.row.assign(state.row.begin(), state.row.end());
  return particles;
}

// Substeps per output frame: the candidate's, or by the time step given on the command line. `cfl` takes the base step
// as its largest and ignores the candidate's.
int choose_substeps(const CliOptions& options, const std::string& rule, const Candidate& candidate,
                    const RunSpecification::Time& time) {
  const double frame_dt = time.frame_dt;
  if (rule == "paper") {
    if (std::abs(candidate.timestep.substeps * candidate.timestep.dt - frame_dt) > 1e-9 * frame_dt) {
      throw invalid_field(options.candidate, "/timestep/dt", candidate.timestep.dt,
                          fmt::format("{} substeps that fill a frame of {} s", candidate.timestep.substeps, frame_dt),
                          "make the candidates again with pm-candidates");
    }
    return candidate.timestep.substeps;
  }
  size_t used = 0;
  double seconds = 0;
  const auto whole = [&](double dt) { return std::max(1, static_cast<int>(std::ceil(frame_dt / dt * (1 - 1e-9)))); };
  if (rule == "cfl") return whole(time.substep_dt);
  try {
    seconds = std::stod(rule, &used);
  } catch (const std::exception&) {
  }
  if (used != rule.size() || !(seconds > 0) || !(frame_dt / seconds < 1e7)) {
    throw Error(ExitCode::usage,
                fmt::format("--timestep: found \"{}\", expected paper, cfl or a positive number of seconds", rule));
  }
  return whole(seconds);
}

// The terms of the energy budget per output frame, as the record names them.
std::vector<std::pair<std::string, std::vector<double>>> energy_terms(const std::vector<mpm::Balance>& balances) {
  using Budget = mpm::EnergyBudget;
  const std::pair<const char*, double Budget::*> terms[] = {
      {"change", &Budget::change},   {"transfer", &Budget::transfer},  {"contact", &Budget::contact},
      {"plastic", &Budget::plastic}, {"viscous", &Budget::viscous},    {"projection", &Budget::projection},
      {"control", &Budget::control}, {"structure", &Budget::structure}};
  std::vector<std::pair<std::string, std::vector<double>>> list;
  for (const auto& [name, term] : terms) {
    list.emplace_back(name, std::vector<double>{});
    for (const mpm::Balance& balance : balances) list.back().second.push_back(balance.budget.*term);
  }
  list.emplace_back("residual", std::vector<double>{});
  for (const mpm::Balance& balance : balances) list.back().second.push_back(balance.budget.residual());
  return list;
}

ExecutionRecord make_record(const Candidate& candidate, const mpm::Problem& problem, const mpm::Result& result,
                            const CliOptions& options, const std::string& rule, int substeps) {
  ExecutionRecord record;
  record.candidate = candidate.id;
  record.diverged = result.status == mpm::Status::diverged;
  if (record.diverged) {
    record.error_tokens.push_back(result.reason);
    record.reason = result.reason == "budget"
                        ? fmt::format("more than {} substeps, which --max-steps allows", options.max_steps)
                        : fmt::format("{} in substep {}", result.reason, result.first_bad_step);
  }
  record.first_bad_step = static_cast<long>(result.first_bad_step);
  record.max_speed = std::isfinite(result.max_speed) ? result.max_speed : 0;
  record.J_min = result.min_J;
  record.J_max = result.max_J;
  record.mass = result.balances.front().mass;
  record.momentum_start = from_mpm(result.balances.front().momentum);
  record.momentum_end = from_mpm(result.balances.back().momentum);
  for (const mpm::Balance& balance : result.balances) {
    record.kinetic.push_back(balance.kinetic);
    if (result.measured_energy) record.elastic.push_back(balance.elastic);
    record.potential.push_back(balance.gravity);
  }
  record.energy_measured = options.energy;
  const mpm::EnergyResidual residual = mpm::energy_residual(result);
  record.energy_residual = std::isfinite(residual.joules) ? residual.joules : 0;
  record.energy_scale = std::isfinite(residual.scale) ? residual.scale : 0;
  if (result.measured_steps) {
    record.largest_step_residual = result.balances.back().budget.largest_step_residual;
    record.energy_terms = energy_terms(result.balances);
  }
  record.particles_outside = static_cast<long>(result.particles_outside);
  record.substeps_per_frame = substeps;
  record.step_rule = rule == "paper" || rule == "cfl" ? rule : "fixed";
  record.smallest_dt = result.history.smallest_dt;
  record.largest_dt = result.history.largest_dt;
  record.retries = static_cast<long>(result.history.retries);
  record.discarded_steps = static_cast<long>(result.history.discarded_steps);
  record.steps = static_cast<long>(result.steps);
  record.dt = result.dt;
  record.frames = result.frames_done;
  record.particles = static_cast<long>(problem.particles.size());
  record.grid = {{"n", problem.domain.n}, {"length", problem.domain.length}};
  record.precision = options.precision;
  for (const mpm::Omission& omission : result.omitted) record.omitted.push_back({omission.what, omission.why});
  record.runtime = {{"seconds",
                     {{"total", result.seconds_total},
                      {"particles", result.seconds_particles},
                      {"grid", result.seconds_grid},
                      {"sort", result.seconds_sort},
                      {"frames", result.seconds_frames}}},
                    {"particle_steps_per_second", result.particle_steps_per_second},
                    {"threads", result.threads},
                    {"solver_particle_bytes", result.particle_bytes},
                    {"solver_grid_bytes", result.grid_bytes},
                    {"peak_memory_bytes", peak_memory_bytes()}};
  return record;
}

int simulate(const CliOptions& options, const CommonOptions& common) {
  const Scene scene = load_scene(options.scene, {});
  const State state = load_state(options.state);
  const Candidate candidate = load_candidate(options.candidate);
  require_made_from(options.candidate, options.state, false);
  RunSpecification run = scene.run;
  if (options.grid > 0) run.grid.n = options.grid;
  if (options.frames > 0) run.time.frames = options.frames;
  if (std::abs(run.grid.length - state.map.length) > 1e-12) {
    throw invalid_input({options.state, "/map/@L", fmt::format("{}", state.map.length),
                         fmt::format("{}, the run's grid length", run.grid.length),
                         "make the state again with pm-lift"});
  }
  mpm::Problem problem;
  problem.domain = bind_domain(run);
  problem.materials = bind_materials(candidate, state, options.candidate);
  problem.constants = bind_constants(run.profile);
  problem.particles = bind_particles(state);
  problem.schedule = bind::bind_schedule(candidate, run);
  mpm::Timing timing;
  timing.frames = run.time.frames;
  timing.frame_dt = run.time.frame_dt;
  const std::string rule = options.timestep.empty() ? run.time.rule : options.timestep;
  timing.substeps = choose_substeps(options, rule, candidate, run.time);
  if (rule == "cfl") timing.rule = mpm::StepRule::cfl;
  mpm::Options solver;
  solver.precision = options.precision == "double" ? mpm::Precision::full : mpm::Precision::single;
  solver.threads = common.threads;
  solver.measure_energy = options.energy != "off";
  solver.measure_steps = options.energy == "steps";
  solver.track_total_F = run.transport.total;
  solver.max_steps = options.max_steps;

  Provenance provenance;
  provenance.tool = "pm-simulate";
  provenance.options = {{"timestep", rule}, {"precision", options.precision}, {"energy", options.energy}};
  if (options.grid > 0) provenance.options.emplace_back("grid", std::to_string(options.grid));
  if (options.frames > 0) provenance.options.emplace_back("frames", std::to_string(options.frames));
  if (options.max_steps != mpm::Options().max_steps)
    provenance.options.emplace_back("max-steps", std::to_string(options.max_steps));
  for (const std::string& input : {options.scene, options.state, options.candidate}) provenance.add_input(input);

  const size_t gaussians = state.gaussian_count();
  const std::string deformation = run.transport.total ? "total" : "elastic";
  RolloutWriter rollout(options.out, gaussians, deformation, provenance);
  std::vector<float> position(3 * gaussians), F(9 * gaussians), velocity(3 * gaussians);
  Progress progress("frame", timing.frames);
  const mpm::Result result = mpm::run(problem, timing, solver, [&](const mpm::Frame& frame) {
    const std::vector<mpm::Mat3d>& transported = run.transport.total ? frame.state.total_F : frame.state.F;
    for (size_t i = 0; i < gaussians; ++i) {
      for (int k = 0; k < 3; ++k) {
        position[3 * i + k] = static_cast<float>(frame.state.x[i][k]);
        velocity[3 * i + k] = static_cast<float>(frame.state.v[i][k]);
        for (int l = 0; l < 3; ++l) F[9 * i + 3 * k + l] = static_cast<float>(transported[i][k][l]);
      }
    }
    rollout.append(frame.time, position.data(), F.data(), velocity.data());
    progress.update(frame.index + 1);
  });
  rollout.commit();
  ExecutionRecord record = make_record(candidate, problem, result, options, rule, timing.substeps);
  record.deformation = deformation;
  save_execution(fs::path(options.out).replace_extension(".json").string(), record, provenance);
  if (!record.diverged) {
    log_info(fmt::format("{}: {} frames, {} substeps of {} particles, {:.1f} million particle-steps per second",
                         candidate.id, record.frames, record.steps, record.particles,
                         result.particle_steps_per_second / 1e6));
    return 0;
  }
  log_warning(fmt::format("{}: diverged ({})", candidate.id, record.reason));
  return options.strict ? static_cast<int>(ExitCode::diverged) : 0;
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
       [&](CLI::App& app) {
         app.add_option("--scene", options.scene, "Scene or its simulate slice")->required();
         app.add_option("--state", options.state, "Labels and particles")->required();
         app.add_option("--candidate", options.candidate, "Candidate to simulate")->required();
         app.add_option("--out", options.out, "Rollout to write, .h5; the record goes beside it")
             ->required()
             ->check([](const std::string& path) {
               return fs::path(path).extension() == ".h5" ? std::string() : "--out: expected a name that ends in .h5";
             });
         app.add_option("--timestep", options.timestep,
                        "paper (the candidate's substeps), cfl (as small as stability asks, changing with the state), "
                        "or seconds; the run's time.rule by default")
             ->group("Numerics");
         app.add_option("--max-steps", options.max_steps, "Substeps after which, or in view of which, the run ends")
             ->check(CLI::Range(1LL, 1000000000000LL))
             ->capture_default_str()
             ->group("Numerics");
         app.add_option("--precision", options.precision, "float or double")
             ->check(CLI::IsMember({"float", "double"}))
             ->capture_default_str()
             ->group("Numerics");
         app.add_option("--energy", options.energy,
                        "Energy balance: off, at output frames, or the budget of all substeps (several times slower)")
             ->check(CLI::IsMember({"off", "frames", "steps"}))
             ->capture_default_str()
             ->group("Numerics");
         app.add_option("--grid", options.grid, "Cells per axis instead of the run's")
             ->check(CLI::Range(16, 512))
             ->group("Numerics");
         app.add_option("--frames", options.frames, "Output frames instead of the run's, rest frame included")
             ->check(CLI::Range(1, 10000))
             ->group("Numerics");
         app.add_flag("--strict", options.strict, "Exit with 5 when the simulation diverges")->group("Numerics");
       },
       [&](const CommonOptions& common) { return simulate(options, common); }});
}
