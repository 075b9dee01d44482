#include "mpm/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/clock.h"
#include "mpm/material/constitutive.h"

namespace physmas::mpm {

namespace {

StepperSetup make_setup(const Problem& problem, const Timing& timing, const Options& options, const ActionPlan& actions,
                        RigidPlan& plan) {
  StepperSetup setup;
  setup.domain = problem.domain;
  setup.contact = problem.contact;
  for (const Material& m : problem.materials) {
    setup.branches.push_back(m.branch);
    setup.parameters.push_back(derive_parameters(m, problem.constants));
  }
  for (const Material& m : problem.particles.material) setup.elasticity.push_back(elasticity_of(m));
  const StiffProblem stiff = {problem.domain.dx(), problem.domain.gravity,   setup.branches,
                              setup.parameters,    setup.elasticity,         problem.object,
                              problem.particles,   problem.schedule.actions, problem.contact.bodies() > 1};
  plan = plan_rigid(stiff, options.stiff, timing.frame_dt / timing.substeps);
  setup.row = plan.row;
  if (!plan.setup.empty()) {
    for (size_t row = setup.branches.size(); row < plan.source_row.size(); ++row) {
      setup.branches.push_back(setup.branches[plan.source_row[row]]);
      setup.parameters.push_back(setup.parameters[plan.source_row[row]]);
    }
    setup.rigid = plan.setup;
    setup.contact = {};
    for (const int body : plan.setup.body_of_row) setup.contact.body.push_back(1 + body);
  }
  setup.volume = problem.particles.volume;
  setup.control_group = actions.group_of();
  setup.track_total_F = options.track_total_F;
  setup.measure_steps = options.measure_steps;
  return setup;
}

State rest_state(const Particles& particles, const StepperSetup& setup) {
  const size_t count = particles.size();
  State state;
  state.x = particles.position;
  state.v = particles.velocity;
  state.v.resize(count, {0, 0, 0});
  state.F = particles.deformation_gradient;
  state.F.resize(count, identity<double>());
  state.C.assign(count, diagonal(0.0, 0.0, 0.0));
  if (setup.track_total_F) state.total_F.assign(count, identity<double>());
  state.strength.resize(count);
  for (size_t i = 0; i < count; ++i) state.strength[i] = setup.parameters[particles.row[i]].yield;
  return state;
}

double total_mass(const StepperSetup& setup) {
  double mass = 0;
  for (size_t i = 0; i < setup.row.size(); ++i) mass += setup.parameters_of(i).density * setup.volume[i];
  return mass;
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

// Above one and a half times the limit at rest every measured run of material with a potential diverges. A stress cone
// takes the energy of the same instability away, so that no check of speed or energy can see it: material falls to
// pieces quietly instead (docs/numerics.md, "Stability"). Infinite when every row has a potential. Particles that are
// moved by an action have no motion of their own and do not count.
double hopeless_step(const StepperSetup& setup) {
  double limit = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < setup.row.size(); ++i) {
    const int row = setup.row[i];
    if (setup.control_group[i] == 0 && !has_potential(setup.branches[row]))
      limit = std::min(limit, 1.5 * rest_limit(setup.parameters_of(i), setup.domain.dx()));
  }
  return limit;
}

// One run. Between output frames the stepper repeats the substep:
//
//   p2g          masses and momenta of the nodes, with the actions' velocities and the stress (paper, Eq. "p2g")
//   grid update  velocities of the nodes (Eq. "gridupdate") and gravity
//   contact      bodies with one another, where they have fields of their own; then colliders and walls
//   g2p          velocities, affine maps, places and deformation of the particles, then the return map
//
// (reference.h has it in plain loops, cpu/cpu_stepper.cpp as the CPU runs it), and at an output frame come
//
//   projections  interface retention after structure projection (Eqs. "structuremotion" and "structurestate")
//   output       the state that transports the Gaussians (Eq. "gaussiantransport"), after a last check.
class Simulation {
 public:
  Simulation(const Problem& problem, const Timing& timing, const Options& options, const FrameCallback& callback);
  Result run();

 private:
  void start();
  void load();
  bool substeps(int frame);
  void projections();
  Balance weigh(int frame);
  bool believable(const Balance& balance);
  void output(const Balance& balance);
  void close();
  void report_rigid();

  StepReport advance(int frame);
  void count(const StepReport& report);
  bool fail(const char* reason);
  void find_culprits();

  const Problem& problem_;
  const Timing& timing_;
  const Options& options_;
  const FrameCallback& callback_;
  const Stopwatch watch_;
  Result result_;

  const ActionPlan actions_;
  RigidPlan plan_;
  const StepperSetup setup_;
  std::vector<CompiledProjection> projections_;
  std::vector<CompiledRetention> retentions_;
  const std::unique_ptr<Stepper> stepper_;
  ImpactWindows windows_;  // of rigid bodies
  AdaptiveStepping adaptive_;
  State state_;

  double control_work_ = 0;  // J since the start
  EnergyBudget budget_;
  // J: no motion can hold more kinetic energy than it began with, plus what gravity can give across the domain, plus
  // what actions and projections put in.
  double available_ = 0;
  std::unique_ptr<EnergyWatch> energy_watch_;
  const double hopeless_;  // s

  bool structured() const { return !projections_.empty() || !retentions_.empty(); }
};

Simulation::Simulation(const Problem& problem, const Timing& timing, const Options& options,
                       const FrameCallback& callback)
    : problem_(problem),
      timing_(timing),
      options_(options),
      callback_(callback),
      actions_(problem.schedule.actions, problem.particles),
      setup_(make_setup(problem, timing, options, actions_, plan_)),
      retentions_(
          CompiledRetention::compile(problem.schedule.retentions, problem.particles, problem.schedule.projections)),
      stepper_(options.stepper ? options.stepper(options.precision, setup_)
                               : make_stepper(options.device, options.precision, setup_)),
      windows_(options.impact_budget, total_mass(setup_)),
      adaptive_(setup_, timing.frame_dt / timing.substeps, (timing.frames - 1) * timing.frame_dt, options.max_steps,
                stepper_->rigid() ? &windows_ : nullptr),
      state_(rest_state(problem.particles, setup_)),
      hopeless_(hopeless_step(setup_)) {
  for (const StructureProjection& p : problem.schedule.projections) projections_.emplace_back(p, problem.particles);
  result_.dt = timing.frame_dt / timing.substeps;
  result_.omitted = omissions(problem, options);
  result_.measured_steps = options.measure_steps;
  result_.measured_energy = options.measure_energy || options.measure_steps;
}

Result Simulation::run() {
  start();
  for (int frame = 1; frame < timing_.frames; ++frame) {
    // Once loaded, the stepper goes on from its own copy unless the state is changed here.
    if (frame == 1 || structured()) load();
    if (!substeps(frame)) break;
    const Stopwatch watch;
    stepper_->store(state_);
    if (structured()) projections();
    const Balance balance = weigh(frame);
    if (!believable(balance)) break;
    output(balance);
    result_.seconds_frames += watch.seconds();
  }
  close();
  return std::move(result_);
}

void Simulation::start() {
  const Balance start = weigh(0);
  output(start);
  // Twice that, plus a little for rounding, is the limit of what is believed (advance).
  const Vec3d& g = setup_.domain.gravity;
  const double fall = setup_.domain.length * (std::fabs(g.x) + std::fabs(g.y) + std::fabs(g.z));
  const double slow = 1e-3 * setup_.domain.dx() / result_.dt;
  // Material that starts deformed brings energy of its own.
  const bool deformed = !problem_.particles.deformation_gradient.empty();
  const double stored = deformed ? stepper_->summarise_elastic(state_).energy : 0;
  available_ = start.kinetic + stored + start.mass * (fall + 0.5 * slow * slow);
  energy_watch_ = std::make_unique<EnergyWatch>(
      start, start.kinetic + stored + start.mass * (setup_.domain.dx() * norm(g) + 0.5 * slow * slow));
}

void Simulation::load() {
  const Stopwatch watch;
  result_.particles_outside = std::max(result_.particles_outside, stepper_->load(state_));
  result_.seconds_frames += watch.seconds();
}

// The substeps before an output frame. False when they end with a fault.
bool Simulation::substeps(int frame) {
  const StepReport report = advance(frame);
  count(report);
  return report.fault == StepFault::none || fail(reason_token(report.fault));
}

StepReport Simulation::advance(int frame) {
  const double energy_limit = 2 * (available_ + control_work_);
  if (timing_.rule == StepRule::cfl) {
    return adaptive_.advance(*stepper_, state_, actions_, (frame - 1) * timing_.frame_dt, timing_.frame_dt,
                             energy_limit);
  }
  if (static_cast<double>(timing_.substeps) * (timing_.frames - 1) > static_cast<double>(options_.max_steps)) {
    StepReport refused;
    refused.fault = StepFault::budget;
    refused.steps = 1;
    return refused;
  }
  const long long first_step = result_.steps;
  if (stepper_->rigid()) {
    const auto timed = [&](double time, double dt, std::vector<Control>& out) {
      return actions_.controls(static_cast<double>(first_step) * result_.dt + time, dt, out);
    };
    return windows_.advance(*stepper_, timing_.substeps, result_.dt, timed, energy_limit);
  }
  const auto controls = [&](int step, std::vector<Control>& out) {
    return actions_.controls(static_cast<double>(first_step + step) * result_.dt, result_.dt, out);
  };
  return stepper_->advance(timing_.substeps, result_.dt, controls, energy_limit);
}

void Simulation::count(const StepReport& report) {
  result_.steps += report.steps;
  result_.max_speed = std::max(result_.max_speed, report.max_speed);
  result_.particles_outside = std::max(result_.particles_outside, report.particles_clamped);
  result_.sorts += report.sorts;
  const StepperUsage usage = stepper_->usage();
  result_.particle_bytes = std::max(result_.particle_bytes, usage.particle_bytes);
  result_.grid_bytes = std::max(result_.grid_bytes, usage.grid_bytes);
  result_.seconds_particles += report.seconds_particles;
  result_.seconds_grid += report.seconds_grid;
  result_.seconds_sort += report.seconds_sort;
  control_work_ += report.control_work;
  budget_.add(report.energy);
}

void Simulation::projections() {
  const auto elastic = [&] { return options_.measure_steps ? stepper_->summarise_elastic(state_).energy : 0.0; };
  const Balance before = measure_balance(setup_, state_);
  const double elastic_before = elastic();
  for (const CompiledProjection& p : projections_) p.apply(state_);
  for (const CompiledRetention& r : retentions_) r.apply(state_);
  const Balance after = measure_balance(setup_, state_);
  control_work_ += std::max(0.0, after.kinetic - before.kinetic);
  if (options_.measure_steps) {
    const double change = after.energy() - before.energy() + elastic() - elastic_before;
    budget_.structure += change;
    budget_.change += change;
  }
}

Balance Simulation::weigh(int frame) {
  Balance b = measure_balance(setup_, state_);
  b.frame = frame;
  b.time = frame * timing_.frame_dt;
  b.control_work = control_work_;
  b.budget = budget_;
  if (result_.measured_energy) {
    const ElasticSummary elastic = stepper_->summarise_elastic(state_);
    b.elastic = elastic.energy;
    b.recoverable = elastic.recoverable;
    b.min_J = elastic.min_J;
    b.max_J = elastic.max_J;
  }
  return b;
}

// Whether the state at an output frame can be the motion's: instabilities that are too weak for the check of every
// substep show here.
bool Simulation::believable(const Balance& balance) {
  if (timing_.rule == StepRule::fixed && result_.dt > hopeless_) return fail("step");
  // Projections move and relax material at will; what they do to the elastic energy is not weighed.
  if (options_.measure_energy && !structured() && energy_watch_->surplus(balance)) {
    return fail(reason_token(StepFault::energy));
  }
  return true;
}

bool Simulation::fail(const char* reason) {
  result_.status = Status::diverged;
  result_.first_bad_step = result_.steps - 1;
  result_.reason = reason;
  find_culprits();
  return false;
}

// Which rows a person should look at.
void Simulation::find_culprits() {
  State last = state_;
  stepper_->store(last);
  result_.fault_speed = -1;
  result_.stiffest_limit = std::numeric_limits<double>::infinity();
  std::vector<bool> seen(plan_.source_row.size(), false);
  for (size_t i = 0; i < last.v.size(); ++i) {
    const int row = plan_.source_row[setup_.row[i]];
    const double squared = dot(last.v[i], last.v[i]);
    const double speed = std::isfinite(squared) ? std::sqrt(squared) : std::numeric_limits<double>::infinity();
    if (speed > result_.fault_speed) {
      result_.fault_speed = speed;
      result_.fault_row = row;
    }
    if (setup_.rigid.body_of(setup_.row[i]) >= 0 || (seen[row] && setup_.elasticity.empty())) continue;
    seen[row] = true;
    const double limit = rest_limit(setup_.parameters_of(i), setup_.domain.dx());
    if (limit < result_.stiffest_limit) {
      result_.stiffest_limit = limit;
      result_.stiffest_row = row;
    }
  }
}

void Simulation::output(const Balance& b) {
  result_.min_J = std::min(result_.min_J, b.min_J);
  result_.max_J = std::max(result_.max_J, b.max_J);
  result_.particles_at_wall = std::max(result_.particles_at_wall, b.at_wall);
  result_.max_speed = std::max(result_.max_speed, b.max_speed);
  result_.balances.push_back(b);
  callback_({b.frame, b.time, state_});
  ++result_.frames_done;
}

void Simulation::report_rigid() {
  result_.stiff_rows = plan_.rows;
  RigidMotion* const rigid = stepper_->rigid();
  for (int b = 0; rigid && b < rigid->count(); ++b) {
    const RigidBodyRest& rest = rigid->rest(b);
    const RigidHistory& history = rigid->history(b);
    RigidBodyReport report;
    for (const StiffRow& row : plan_.rows) {
      if (std::find(row.bodies.begin(), row.bodies.end(), b) != row.bodies.end()) report.rows.push_back(row.row);
    }
    report.mass = rest.mass;
    report.impacts = history.impacts;
    report.restitution = history.restitution;
    report.largest_acceleration = history.largest_acceleration;
    report.largest_jump = history.largest_jump;
    for (const int i : rest.particles) {
      report.error = std::max(
          report.error, rigid_error(rest, setup_.domain.dx(), setup_.parameters_of(i), history.largest_acceleration));
      if (setup_.elasticity.empty()) break;
    }
    result_.rigid_bodies.push_back(report);
  }
  result_.impacts = windows_.history();
}

// What is known at the end only.
void Simulation::close() {
  report_rigid();
  result_.history = adaptive_.history();
  if (timing_.rule == StepRule::fixed) result_.history.smallest_dt = result_.history.largest_dt = result_.dt;
  if (result_.history.steps > 0) result_.dt = result_.history.time / static_cast<double>(result_.history.steps);
  const StepperUsage usage = stepper_->usage();
  result_.threads = usage.threads;
  if (result_.steps > 0) {
    const int share = static_cast<int>(std::max(0.0, 100 * (1 - usage.grid_share)));
    result_.omitted.push_back(
        {"empty grid blocks", std::to_string(share) + " % of the grid held no material at the end"});
  }
  // The state that callers see, the setup, and the solver's own copy.
  const size_t particles = setup_.row.size();
  result_.particle_bytes += particles * ((3 + 3 + 9 + 9 + 1 + (options_.track_total_F ? 9 : 0)) * sizeof(double) +
                                         sizeof(double) + sizeof(int) + sizeof(std::uint16_t));
  result_.seconds_total = watch_.seconds();
  const double stepping = result_.seconds_particles + result_.seconds_grid + result_.seconds_sort;
  if (stepping > 0) result_.particle_steps_per_second = static_cast<double>(particles) * result_.steps / stepping;
}

}  // namespace

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
  return Simulation(problem, timing, options, callback).run();
}

}  // namespace physmas::mpm
