#include "mpm/simulation.h"

#include <algorithm>

#include "base/clock.h"
#include "mpm/material/constitutive.h"

namespace physmas::mpm {

namespace {

State rest_state(const Problem& problem, const StepperSetup& setup) {
  const size_t count = problem.particles.size();
  State state;
  state.x = problem.particles.position;
  state.v = problem.particles.velocity;
  state.v.resize(count, {0, 0, 0});
  state.F = problem.particles.deformation_gradient;
  state.F.resize(count, identity<double>());
  state.C.assign(count, diagonal(0.0, 0.0, 0.0));
  if (setup.track_total_F) state.total_F.assign(count, identity<double>());
  state.strength.resize(count);
  for (size_t i = 0; i < count; ++i) state.strength[i] = setup.parameters[problem.particles.row[i]].yield;
  return state;
}

const char* reason_token(StepFault fault) {
  switch (fault) {
    case StepFault::not_finite:
      return "nan";
    case StepFault::speed:
      return "speed";
    case StepFault::energy:
      return "energy";
    case StepFault::budget:
      return "budget";
    case StepFault::none:
      break;
  }
  return "";
}

// Total energy may only fall between output frames, but for what controls put in. An unstable step can also saturate
// at a few times the energy of the motion, below the limit of the substeps' own check: this finds it at the next frame.
// Rows whose stress has no potential count with their kinetic energy and their weight only; what they store at the
// start may all come back.
class EnergyWatch {
 public:
  // scale [J]: energy that may move besides a change of height.
  EnergyWatch(const Balance& start, double scale) : start_(start), scale_(scale) {}

  bool surplus(const Balance& b) {
    constexpr double kTolerance = 0.1;  // stable runs stay below 0.001 (make stability)
    fall_ = std::max(fall_, std::fabs(b.gravity - start_.gravity));
    const double total = b.kinetic + b.recoverable + b.gravity;
    const double gain = total - (start_.kinetic + start_.elastic + start_.gravity) - 2 * b.control_work;
    return gain > kTolerance * (scale_ + fall_ + b.control_work);
  }

 private:
  Balance start_;
  double scale_, fall_ = 0;
};

// Above one and a half times the limit at rest every measured run of material with a potential diverges. A stress cone
// takes the energy of the same instability away, so that no check of speed or energy can see it: material falls to
// pieces quietly instead (docs/numerics.md, "Stability"). Infinite when every row has a potential. Particles that are
// moved by an action have no motion of their own and do not count.
double hopeless_step(const StepperSetup& setup) {
  double limit = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < setup.row.size(); ++i) {
    const int row = setup.row[i];
    if (setup.control_group[i] == 0 && !has_potential(setup.branches[row]))
      limit = std::min(limit, 1.5 * rest_limit(setup.parameters[row], setup.domain.dx()));
  }
  return limit;
}

std::vector<Omission> omissions(const Problem& problem, const Options& options) {
  std::vector<Omission> list;
  bool used[kBranchCount] = {}, svd = false;
  for (const int row : problem.particles.row) used[static_cast<int>(problem.materials[row].branch)] = true;
  for (int b = 0; b < kBranchCount; ++b) {
    if (!used[b]) list.push_back({std::string("branch ") + kBranchNames[b], "no particle belongs to it"});
    svd = svd || (used[b] && needs_principal_stretches(static_cast<Branch>(b)));
  }
  if (!svd) list.push_back({"principal stretches", "no present branch needs them"});
  if (problem.domain.colliders.empty()) list.push_back({"colliders", "none are configured"});
  if (problem.schedule.actions.empty()) list.push_back({"actions", "none are scheduled"});
  if (problem.schedule.projections.empty()) list.push_back({"structure projection", "no row is projected"});
  if (problem.schedule.retentions.empty()) list.push_back({"interface retention", "no support retains its neighbours"});
  if (!options.track_total_F) list.push_back({"total deformation", "frames hold the elastic one"});
  if (!options.measure_energy && !options.measure_steps) {
    list.push_back({"elastic energy and det F range", "not asked for"});
  }
  if (!options.measure_steps) list.push_back({"energy budget of every substep", "not asked for"});
  return list;
}

}  // namespace

Balance measure_balance(const Problem& problem, const State& state) {
  Balance b;
  const double dx = problem.domain.dx();
  // An APIC particle carries the angular momentum of its affine field: inertia m dx²/4 per axis (Jiang et al. 2015).
  const double spread = dx * dx / 4;
  const double wall_low = (problem.domain.wall_cells + 1.5) * dx;
  const double wall_high = problem.domain.length - wall_low;
  for (size_t i = 0; i < state.size(); ++i) {
    const double m = problem.materials[problem.particles.row[i]].rho * problem.particles.volume[i];
    const Vec3d& x = state.x[i];
    const Vec3d& v = state.v[i];
    const Mat3d& C = state.C[i];
    const Vec3d spin = {C[2][1] - C[1][2], C[0][2] - C[2][0], C[1][0] - C[0][1]};
    b.mass += m;
    b.kinetic += 0.5 * m * dot(v, v);
    b.affine += 0.5 * m * spread * squared_norm(C);
    b.gravity -= m * dot(problem.domain.gravity, x);
    b.momentum = b.momentum + m * v;
    b.angular_momentum = b.angular_momentum + m * (cross(x, v) + spread * spin);
    b.max_speed = std::max(b.max_speed, norm(v));
    const double low = std::min({x.x, x.y, x.z}), high = std::max({x.x, x.y, x.z});
    b.at_wall += low < wall_low || high > wall_high;
  }
  return b;
}

EnergyResidual energy_residual(const Result& result) {
  EnergyResidual r;
  r.measured = result.measured_energy;
  r.per_step = result.measured_steps;
  if (!r.measured) return r;
  double lowest = 0;  // of the total energy less the work of controls
  for (const Balance& b : result.balances) {
    const Balance& first = result.balances.front();
    r.scale = std::max({r.scale, b.kinetic + b.affine + b.elastic, std::fabs(b.gravity - first.gravity)});
    const double own = b.energy() - b.control_work;
    if (b.frame == 0 || own < lowest) lowest = own;
    r.joules = std::max(r.joules, r.per_step ? std::fabs(b.budget.residual()) : own - lowest);
  }
  return r;
}

Result run(const Problem& problem, const Timing& timing, const Options& options, const FrameCallback& callback) {
  check_problem(problem, timing);
  const Stopwatch total;
  Result result;
  // With fewer particles threads wait for one another for longer than they save.
  constexpr int kParticlesPerThread = 2000;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  result.threads = std::max(1, std::min(options.threads > 0 ? options.threads : cores,
                                        static_cast<int>(problem.particles.size()) / kParticlesPerThread));
  Team team(result.threads);
  result.dt = timing.frame_dt / timing.substeps;
  result.omitted = omissions(problem, options);

  const ActionPlan actions(problem.schedule.actions, problem.particles);
  std::vector<CompiledProjection> projections;
  for (const StructureProjection& p : problem.schedule.projections) projections.emplace_back(p, problem.particles);
  const auto retentions = CompiledRetention::compile(problem.schedule.retentions, problem.particles);

  StepperSetup setup;
  setup.domain = problem.domain;
  for (const Material& m : problem.materials) {
    setup.branches.push_back(m.branch);
    setup.parameters.push_back(derive_parameters(m, problem.constants));
  }
  setup.row = problem.particles.row;
  setup.volume = problem.particles.volume;
  setup.control_group = actions.group_of();
  setup.track_total_F = options.track_total_F;
  setup.team = &team;
  setup.measure_steps = result.measured_steps = options.measure_steps;
  result.measured_energy = options.measure_energy || options.measure_steps;
  const auto stepper = make_stepper(options.precision, setup);
  State state = rest_state(problem, setup);

  double control_work = 0;
  EnergyBudget budget;
  const auto balance_at = [&](int frame) {
    Balance b = measure_balance(problem, state);
    b.frame = frame;
    b.time = frame * timing.frame_dt;
    b.control_work = control_work;
    b.budget = budget;
    if (result.measured_energy) {
      const ElasticSummary elastic = summarise_elastic(setup, state);
      b.elastic = elastic.energy;
      b.recoverable = elastic.recoverable;
      b.min_J = elastic.min_J;
      b.max_J = elastic.max_J;
    }
    return b;
  };
  const auto hand_out = [&](const Balance& b) {
    result.min_J = std::min(result.min_J, b.min_J);
    result.max_J = std::max(result.max_J, b.max_J);
    result.particles_at_wall = std::max(result.particles_at_wall, b.at_wall);
    result.max_speed = std::max(result.max_speed, b.max_speed);
    result.balances.push_back(b);
    callback({b.frame, b.time, state});
    ++result.frames_done;
  };
  hand_out(balance_at(0));

  // No motion can hold more kinetic energy than it began with, plus what gravity can give across the domain, plus what
  // actions and projections put in. Twice that, plus a little for rounding, is the limit of what is believed.
  const Balance& start = result.balances[0];
  const Vec3d& g = problem.domain.gravity;
  const double fall = problem.domain.length * (std::fabs(g.x) + std::fabs(g.y) + std::fabs(g.z));
  const double slow = 1e-3 * problem.domain.dx() / result.dt;
  // Material that starts deformed brings energy of its own.
  const bool deformed = !problem.particles.deformation_gradient.empty();
  const double stored = deformed ? summarise_elastic(setup, state).energy : 0;
  const double available = start.kinetic + stored + start.mass * (fall + 0.5 * slow * slow);

  EnergyWatch watch(start, start.kinetic + stored + start.mass * (problem.domain.dx() * norm(g) + 0.5 * slow * slow));

  const double hopeless = hopeless_step(setup);
  AdaptiveStepping adaptive(setup, result.dt, (timing.frames - 1) * timing.frame_dt, options.max_steps);
  const auto advance = [&](int frame, double energy_limit) {
    if (timing.rule == StepRule::cfl) {
      return adaptive.advance(*stepper, state, actions, (frame - 1) * timing.frame_dt, timing.frame_dt, energy_limit);
    }
    StepReport refused;
    refused.fault = StepFault::budget;
    refused.steps = 1;
    if (static_cast<double>(timing.substeps) * (timing.frames - 1) > static_cast<double>(options.max_steps))
      return refused;
    const long long first_step = result.steps;
    const auto controls = [&](int step, std::vector<Control>& out) {
      return actions.controls(static_cast<double>(first_step + step) * result.dt, result.dt, out);
    };
    return stepper->advance(timing.substeps, result.dt, controls, energy_limit);
  };

  // Once loaded, the stepper goes on from its own copy unless the state is changed here.
  const bool structured = !projections.empty() || !retentions.empty();
  for (int frame = 1; frame < timing.frames; ++frame) {
    if (frame == 1 || structured) {
      const Stopwatch load_watch;
      result.particles_outside = std::max(result.particles_outside, stepper->load(state));
      result.seconds_frames += load_watch.seconds();
    }
    const StepReport report = advance(frame, 2 * (available + control_work));
    result.steps += report.steps;
    result.max_speed = std::max(result.max_speed, report.max_speed);
    result.particles_outside = std::max(result.particles_outside, report.particles_clamped);
    result.sorts += report.sorts;
    result.particle_bytes = std::max(result.particle_bytes, stepper->particle_bytes());
    result.grid_bytes = std::max(result.grid_bytes, stepper->grid_bytes());
    result.seconds_particles += report.seconds_particles;
    result.seconds_grid += report.seconds_grid;
    result.seconds_sort += report.seconds_sort;
    control_work += report.control_work;
    budget.add(report.energy);
    if (report.fault != StepFault::none) {
      result.status = Status::diverged;
      result.first_bad_step = result.steps - 1;
      result.reason = reason_token(report.fault);
      break;
    }
    const Stopwatch frame_watch;
    stepper->store(state);
    if (structured) {
      const auto elastic = [&] { return options.measure_steps ? summarise_elastic(setup, state).energy : 0.0; };
      const Balance before = measure_balance(problem, state);
      const double elastic_before = elastic();
      for (const CompiledProjection& p : projections) p.apply(state);
      for (const CompiledRetention& r : retentions) r.apply(state);
      const Balance after = measure_balance(problem, state);
      control_work += std::max(0.0, after.kinetic - before.kinetic);
      if (options.measure_steps) {
        const double change = after.energy() - before.energy() + elastic() - elastic_before;
        budget.structure += change;
        budget.change += change;
      }
    }
    const Balance balance = balance_at(frame);
    if (timing.rule == StepRule::fixed && result.dt > hopeless) {
      result.status = Status::diverged;
      result.first_bad_step = result.steps - 1;
      result.reason = "step";
      break;
    }
    // Projections move and relax material at will; what they do to the elastic energy is not weighed.
    if (options.measure_energy && !structured && watch.surplus(balance)) {
      result.status = Status::diverged;
      result.first_bad_step = result.steps - 1;
      result.reason = reason_token(StepFault::energy);
      break;
    }
    hand_out(balance);
    result.seconds_frames += frame_watch.seconds();
  }
  result.history = adaptive.history();
  if (timing.rule == StepRule::fixed) result.history.smallest_dt = result.history.largest_dt = result.dt;
  if (result.history.steps > 0) result.dt = result.history.time / static_cast<double>(result.history.steps);
  if (result.steps > 0) {
    const double blocks = std::pow((problem.domain.n + 4) / 4, 3);
    const double share = 100 * (1 - stepper->active_grid_blocks() / blocks);
    result.omitted.push_back({"empty grid blocks", std::to_string(static_cast<int>(std::max(0.0, share))) +
                                                       " % of the grid held no material at the end"});
  }
  // The state that callers see, the setup, and the solver's own copy.
  result.particle_bytes +=
      problem.particles.size() * ((3 + 3 + 9 + 9 + 1 + (options.track_total_F ? 9 : 0)) * sizeof(double) +
                                  sizeof(double) + sizeof(int) + sizeof(std::uint16_t));
  result.seconds_total = total.seconds();
  const double stepping = result.seconds_particles + result.seconds_grid + result.seconds_sort;
  if (stepping > 0) {
    result.particle_steps_per_second = static_cast<double>(problem.particles.size()) * result.steps / stepping;
  }
  return result;
}

}  // namespace physmas::mpm
