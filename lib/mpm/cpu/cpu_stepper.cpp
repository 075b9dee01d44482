#include "mpm/cpu/cpu_stepper.h"

#include <algorithm>
#include <atomic>

#include "base/clock.h"
#include "base/kernels.h"
#include "mpm/cpu/block_pass.h"
#include "mpm/cpu/state_summary.h"

namespace physmas::mpm {

namespace {

// A sort is due before particles could drift this far [cells]: blocks reach one cell beyond their own.
constexpr double kDriftLimit = 0.999;
// A sort pays once the strays since the last one, per particle, have cost as much: for a loss that grows evenly that is
// the least on average.
constexpr double kStraysPerSort = 2;
// With fewer particles threads wait for one another for longer than they save.
constexpr int kParticlesPerThread = 2000;

template <class T>
class CpuStepper final : public Stepper {
 public:
  CpuStepper(int threads, const StepperSetup& setup);
  long long load(const State& state) override {
    const bool held = !setup_.rigid.empty() && (!loaded_ || rigid_.held());
    loaded_ = true;
    if (!held) return load_particles(state);
    scratch_ = state;
    return hold_bodies();
  }
  void store(State& state) const override {
    store_.store(state);
    if (rigid_.held()) rigid_.store(state);
  }
  StepReport advance(int steps, double dt, const ControlSource& controls, double energy_limit) override;
  ElasticSummary summarise_elastic(const State& state) override { return mpm::summarise_elastic(setup_, state, team_); }
  StepBounds measure_bounds(const State& state) override {
    return mpm::measure_bounds(setup_, state, team_, rigid_.held());
  }
  RigidMotion* rigid() override { return setup_.rigid.empty() ? nullptr : &rigid_; }
  void hold(bool rigid) override;
  StepperUsage usage() const override {
    const double blocks = std::pow((setup_.domain.n + kBlock) / kBlock, 3);
    return {team_.threads(), static_cast<double>(store_.map.grid_blocks.size()) / blocks, store_.bytes(),
            grid_.bytes()};
  }

 private:
  void prepare();
  long long load_particles(const State& state) {
    drift_ = 0;
    strays_ = 0;
    const long long clamped = store_.load(state);
    prepare();
    return clamped;
  }
  // Takes the bodies up as they are in scratch_, and loads that.
  long long hold_bodies() {
    rigid_.hold(scratch_, mass_);
    rigid_.store(scratch_);
    return load_particles(scratch_);
  }
  void prescribe_bodies();
  // The phases of a substep. Where one follows another, G2P of a substep and P2G of the next are one pass over the
  // particles, which read and write their numbers once.
  void p2g(double dt, StepReport& report) { pass<false, true>(dt, report); }
  // False: rigid bodies are to be let go first.
  bool grid_update_and_contact(double dt, bool fresh, StepReport& report);
  void g2p(double dt, StepReport& report) { pass<true, false>(dt, report); }
  void g2p_and_p2g(double dt, StepReport& report) { pass<true, true>(dt, report); }

  void expect_actions(double dt);
  void sort_if_due(StepReport& report);
  void sort(StepReport& report);
  template <bool kGather, bool kScatter>
  void pass(double dt, StepReport& report);

  StepperSetup setup_;
  Team team_;
  double dx_;
  std::vector<MaterialParameters<T>> parameters_;
  ParticleStore<T> store_;
  Grid<T> grid_;
  std::vector<BlockReport> reports_;              // per particle block
  std::vector<std::atomic<std::uint32_t>> done_;  // per run of blocks: the last pass that it is through
  std::uint32_t pass_ = 0;                        // counts the passes
  EnergyLedger ledger_;

  long long strays_ = 0;         // particles that columns have lost since the sort, summed over substeps
  double drift_ = 0;             // cells since the last sort, at most
  double next_drift_ = 0;        // cells in the coming pass, at most
  double kinetic_ = 0;           // J, of the last gathered substep
  ControlTable before_, after_;  // of the substep that is scattered, of the one that was gathered
  RigidMotion rigid_;
  std::vector<std::vector<std::uint16_t>> body_controls_;  // per rigid body: control groups of its particles
  std::vector<double> mass_;                               // per particle [kg], where there are rigid bodies
  State scratch_;
  bool loaded_ = false;
  BlockPass<T> block_pass_{setup_, parameters_, store_, grid_, rigid_, before_, after_};
};

template <class T>
CpuStepper<T>::CpuStepper(int threads, const StepperSetup& setup)
    : setup_(setup),
      team_(threads),
      dx_(setup.domain.dx()),
      store_(setup_, team_, kSafeCells),
      grid_(setup_, team_, store_.map),
      rigid_(setup_.rigid, dx_, setup_.domain.gravity) {
  for (const auto& p : setup_.parameters) parameters_.push_back(convert_parameters<T>(p));
  for (const RigidBodyRest& body : setup_.rigid.bodies) {
    std::vector<std::uint16_t> groups;
    for (const int i : body.particles) {
      const std::uint16_t group = setup_.control_group[i];
      if (group != 0 && std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
    }
    body_controls_.push_back(groups);
  }
  for (size_t i = 0; !setup_.rigid.empty() && i < setup_.row.size(); ++i) {
    mass_.push_back(setup_.parameters_of(i).density * setup_.volume[i]);
  }
}

template <class T>
void CpuStepper<T>::hold(bool rigid) {
  if (setup_.rigid.empty() || rigid == rigid_.held()) return;
  store(scratch_);
  if (rigid) {
    hold_bodies();
    return;
  }
  rigid_.let_go();
  load_particles(scratch_);
}

// What enforces the motion of a part of a body enforces that of all of it.
template <class T>
void CpuStepper<T>::prescribe_bodies() {
  for (int b = 0; b < rigid_.count(); ++b) {
    const Control* enforced = nullptr;
    for (const std::uint16_t group : body_controls_[b]) {
      if (!enforced && before_.active && before_.group[group].enforces()) enforced = &before_.group[group];
    }
    rigid_.prescribe(b, enforced);
  }
}

template <class T>
void CpuStepper<T>::prepare() {
  grid_.prepare();
  if (!setup_.rigid.empty()) rigid_.set_near(grid_.near_rigid());
  reports_.assign(store_.map.particle_blocks.size(), {});
  done_ = std::vector<std::atomic<std::uint32_t>>(store_.map.waits_for.size());
}

// Needs no velocities: it happens between the grid update and the next gather.
template <class T>
void CpuStepper<T>::sort(StepReport& report) {
  const Stopwatch watch;
  store_.sort();
  prepare();
  drift_ = 0;
  strays_ = 0;
  ++report.sorts;
  report.seconds_sort += watch.seconds();
}

template <class T>
bool CpuStepper<T>::grid_update_and_contact(double dt, bool fresh, StepReport& report) {
  const Stopwatch watch;
  GridEnergy energy;
  // Particle velocities are convex combinations of node velocities, so none is faster than the fastest node.
  double speed = 0;
  if (setup_.rigid.empty()) {
    speed = grid_.update(dt, energy);
  } else {
    const double before = rigid_.kinetic();
    prescribe_bodies();
    if (!grid_.update(dt, fresh, rigid_, speed, report.push, energy)) {
      report.seconds_grid += watch.seconds();
      return false;
    }
    if (before_.active && rigid_.prescribes()) {
      report.control_work += std::max(0.0, rigid_.kinetic() - before);
    }
  }
  next_drift_ = speed * dt / dx_;
  if (setup_.measure_steps) ledger_.grid(energy);
  report.seconds_grid += watch.seconds();
  return true;
}

template <class T>
template <bool kGather, bool kScatter>
void CpuStepper<T>::pass(double dt, StepReport& report) {
  const Stopwatch watch;
  // Threads take runs of blocks by colour and meet at no node; where neighbours of another colour are at work, they
  // wait. So every node sums in the same order, whatever the threads.
  const BlockMap& map = store_.map;
  ++pass_;
  const auto for_each_block = [&](const auto& work) {
    team_.for_each(map.thread_bounds, [&](int run) {
      for (const int other : map.waits_for[run]) {
        for (int round = 0; kScatter && done_[other].load(std::memory_order_acquire) != pass_; ++round) {
          Team::pause(round);
        }
      }
      for (int k = map.run_bounds[run]; k < map.run_bounds[run + 1]; ++k) work(map.order[k]);
      done_[run].store(pass_, std::memory_order_release);
    });
  };
  if (setup_.measure_steps) {
    for_each_block([&](int b) { reports_[b] = block_pass_.template run<kGather, kScatter, true>(b, dt); });
    ParticleEnergy energy;
    for (const BlockReport& r : reports_) energy.add(r.energy);
    kGather ? ledger_.finish(energy) : report.steps > 0 ? ledger_.resume(energy) : ledger_.begin(energy);
    report.energy = ledger_.total();
  } else {
    for_each_block([&](int b) { reports_[b] = block_pass_.template run<kGather, kScatter, false>(b, dt); });
  }
  double kinetic = 0, speed_squared = 0;
  long long clamped = 0;
  for (const BlockReport& r : reports_) {
    kinetic += r.kinetic;
    report.control_work += r.control_work;
    speed_squared = std::max(speed_squared, r.max_speed_squared);
    clamped += r.clamped;
    strays_ += r.strays;
    if (r.not_finite) report.fault = StepFault::not_finite;
  }
  if (kGather) {
    kinetic_ = kinetic;
    report.particles_clamped = std::max(report.particles_clamped, clamped);
    report.max_speed = std::max(report.max_speed, std::sqrt(speed_squared));
    if (report.fault == StepFault::none && std::sqrt(speed_squared) * dt > dx_) report.fault = StepFault::speed;
  }
  report.seconds_particles += watch.seconds();
}

// Actions may move particles farther than the nodes do.
template <class T>
void CpuStepper<T>::expect_actions(double dt) {
  if (!after_.active) return;
  double enforced = 0, increment = 0;
  for (const Control& c : after_.group) {
    if (c.enforces()) enforced = std::max(enforced, c.top_speed());
    const double weight = std::max(c.position.along, c.position.across);
    if (weight > 0) increment = std::max(increment, weight * c.speed_limit);
  }
  // Motion that is enforced in one direction only keeps what it has in the others.
  next_drift_ = std::hypot(next_drift_, enforced * dt / dx_) + increment * dt / dx_;
}

template <class T>
void CpuStepper<T>::sort_if_due(StepReport& report) {
  const bool strayed = static_cast<double>(strays_) > kStraysPerSort * static_cast<double>(setup_.row.size());
  if (drift_ > 0 && (strayed || !(drift_ + next_drift_ <= kDriftLimit))) sort(report);
}

template <class T>
StepReport CpuStepper<T>::advance(int steps, double dt, const ControlSource& controls, double energy_limit) {
  StepReport report;
  if (steps <= 0 || store_.slots() == 0) return report;
  before_.active = controls(0, before_.group);
  store_.keeps_motion = !setup_.rigid.empty();
  p2g(dt, report);
  store_.keeps_motion = false;
  // While rigid bodies may run into something the state before each substep is kept.
  bool fresh = true;
  while (true) {
    if (!grid_update_and_contact(dt, fresh, report)) {
      grid_.clear();
      report.impact = true;
      return report;
    }
    std::swap(after_, before_);
    expect_actions(dt);
    sort_if_due(report);
    const bool last = report.steps + 1 == steps;
    fresh = rigid_.held() && rigid_.alert();
    if (last) {
      g2p(dt, report);
    } else if (fresh) {
      g2p(dt, report);
    } else {
      before_.active = controls(report.steps + 1, before_.group);
      g2p_and_p2g(dt, report);
    }
    drift_ += next_drift_;
    ++report.steps;
    if (fresh && !last && report.fault == StepFault::none) {
      before_.active = controls(report.steps, before_.group);
      store_.keeps_motion = true;
      p2g(dt, report);
      store_.keeps_motion = false;
    }
    if (report.fault == StepFault::none && kinetic_ > energy_limit + 2 * report.control_work) {
      report.fault = StepFault::energy;
    }
    if (report.fault != StepFault::none) grid_.clear();
    if (last || report.fault != StepFault::none) return report;
  }
}

}  // namespace

namespace PHYSMAS_KERNELS {

std::unique_ptr<Stepper> make_cpu_stepper(int threads, Precision precision, const StepperSetup& setup) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int most = static_cast<int>(setup.row.size()) / kParticlesPerThread;
  threads = std::max(1, std::min(threads > 0 ? threads : cores, most));
  if (precision == Precision::full) return std::make_unique<CpuStepper<double>>(threads, setup);
  return std::make_unique<CpuStepper<float>>(threads, setup);
}

}  // namespace PHYSMAS_KERNELS

}  // namespace physmas::mpm
