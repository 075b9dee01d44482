#include "mpm/stepper.h"

#include <algorithm>
#include <cstring>

#include "base/clock.h"
#include "mpm/apply_control.h"
#include "mpm/constitutive.h"
#include "mpm/energy_budget.h"
#include "mpm/grid.h"
#include "mpm/particle_store.h"
#include "mpm/row_transfer.h"

namespace physmas::mpm {

namespace {

// Particles stay this many cells away from the edge of the grid, inside the domain walls: every node of a stencil
// exists.
constexpr double kSafeCells = 2;
// A sort is due before particles could drift this far [cells]: the arenas leave room for one cell.
constexpr double kDriftLimit = 0.999;
// Registers of particles that are fetched ahead.
constexpr int kPrefetch = 2;

// What one block reports from one pass; summed in block order, so totals do not depend on the threads.
struct BlockReport {
  double kinetic = 0;       // J
  double control_work = 0;  // J
  double max_speed_squared = 0;
  int clamped = 0;
  bool not_finite = false;
  ParticleEnergy energy;  // when measured
};

template <class T>
class TypedStepper final : public Stepper {
 public:
  explicit TypedStepper(const StepperSetup& setup);
  long long load(const State& state) override {
    drift_ = 0;
    const long long clamped = store_.load(state);
    prepare();
    return clamped;
  }
  void store(State& state) const override { store_.store(state); }
  StepReport advance(int steps, double dt, const ControlSource& controls, double energy_limit) override;
  int active_grid_blocks() const override { return static_cast<int>(store_.map.grid_blocks.size()); }
  size_t particle_bytes() const override { return store_.bytes(); }
  size_t grid_bytes() const override { return grid_.bytes(); }

 private:
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;
  static_assert(W == Row<T>::kPart);

  struct Crossing;
  // Where a register of particles is: base nodes, weights, and the way from the particle to the centre node [cells].
  struct Place {
    Vec3<V> base, to_center;
    V weight[3][3];
  };

  void prepare();
  void sort(StepReport& report);
  void update_grid(double dt, StepReport& report);
  template <bool kGather, bool kScatter>
  void pass(double dt, StepReport& report);
  template <bool kGather, bool kScatter, bool kMeasure>
  void process_block(int block, double dt);
  MaterialParameters<V> group_parameters(int group, int first) const;
  Mat3<V> update_stress(int group, int first, const MaterialParameters<V>& p, const V& dt, Mat3<V>& F,
                        V& strength) const;

  StepperSetup setup_;
  double dx_;
  std::vector<MaterialParameters<T>> parameters_;
  ParticleStore<T> store_;
  Grid<T> grid_;
  std::vector<BlockReport> reports_;  // per particle block
  EnergyLedger ledger_;

  double drift_ = 0;             // cells since the last sort, at most
  double next_drift_ = 0;        // cells in the coming pass, at most
  double kinetic_ = 0;           // J, of the last gathered substep
  ControlTable before_, after_;  // of the substep that is scattered, of the one that was gathered
};

// One register of particles between lanes, where stress is evaluated, and records, which meet the grid one by one.
template <class T>
struct TypedStepper<T>::Crossing {
  alignas(64) T record[W][16];
  alignas(64) T weight[9][W];  // three along x, y and z
  alignas(64) T lanes[16][W];
  alignas(64) int offset[W];  // of the stencil in the arena

  void place(const Place& at) {
    for (int k = 0; k < 9; ++k) at.weight[k / 3][k % 3].copy_to(weight[k], stdx::vector_aligned);
    const V node = (at.base[0] * T(kArena) + at.base[1]) * T(kArena) + at.base[2] + T(1 + kArena + kArena * kArena);
    typedef T Numbers __attribute__((vector_size(sizeof(V))));
    typedef int Integers __attribute__((vector_size(W * sizeof(int))));
    const Integers offsets = __builtin_convertvector(same_bytes<Numbers>(V(T(4)) * node), Integers);
    std::memcpy(offset, &offsets, sizeof(offsets));
  }
  void gather(const T* arena, int l) {
    T w[9];
    for (int k = 0; k < 9; ++k) w[k] = weight[k][l];
    gather_particle(arena + offset[l], w, w + 3, w + 6, record[l]);
  }
  void scatter(Row<T>* sum, int l) const {
    T w[9];
    for (int k = 0; k < 9; ++k) w[k] = weight[k][l];
    scatter_particle(sum, w, w + 3, w + 6, record[l]);
  }
  void write(const V& mass, const Vec3<V>& momentum, const Mat3<V>& Q) {
    mass.copy_to(lanes[0], stdx::vector_aligned);
    for (int a = 0; a < 3; ++a) {
      momentum[a].copy_to(lanes[1 + a], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) Q[a][b].copy_to(lanes[4 + 4 * b + 1 + a], stdx::vector_aligned);
    }
    for (int k = 4; k < 16; k += 4) V(T(0)).copy_to(lanes[k], stdx::vector_aligned);
    lanes_to_records<T>(lanes, record);
  }
};

template <class T>
TypedStepper<T>::TypedStepper(const StepperSetup& setup)
    : setup_(setup), dx_(setup.domain.dx()), store_(setup_, kSafeCells), grid_(setup_, store_.map) {
  for (const auto& p : setup_.parameters) parameters_.push_back(convert_parameters<T>(p));
}

template <class T>
void TypedStepper<T>::prepare() {
  grid_.prepare();
  reports_.assign(store_.map.particle_blocks.size(), {});
}

// Needs no velocities: it happens between the grid update and the next gather.
template <class T>
void TypedStepper<T>::sort(StepReport& report) {
  const Stopwatch watch;
  store_.sort();
  prepare();
  drift_ = 0;
  ++report.sorts;
  report.seconds_sort += watch.seconds();
}

template <class T>
void TypedStepper<T>::update_grid(double dt, StepReport& report) {
  const Stopwatch watch;
  GridEnergy energy;
  // Particle velocities are convex combinations of node velocities, so none is faster than the fastest node.
  next_drift_ = grid_.update(dt, energy) * dt / dx_;
  if (setup_.measure_steps) ledger_.grid(energy);
  report.seconds_grid += watch.seconds();
}

// Parameters of the lanes of a group: the same in all lanes unless rows are mixed.
template <class T>
MaterialParameters<typename TypedStepper<T>::V> TypedStepper<T>::group_parameters(int group, int first) const {
  const int common = store_.group_row[group];
  if (common >= 0) return convert_parameters<V>(parameters_[common]);
  alignas(64) T lanes[kMaterialParameterCount][W];
  int row = 0;
  for (int l = 0; l < W; ++l) {
    const int i = store_.particle[first + l];
    if (i >= 0) row = setup_.row[i];
    T numbers[kMaterialParameterCount];
    static_assert(sizeof(numbers) == sizeof(MaterialParameters<T>));
    std::memcpy(numbers, &parameters_[row], sizeof(numbers));
    for (int k = 0; k < kMaterialParameterCount; ++k) lanes[k][l] = numbers[k];
  }
  const auto at = [&](int k) { return V(lanes[k], stdx::vector_aligned); };
  return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8), at(9), at(10)};
}

template <class T>
Mat3<typename TypedStepper<T>::V> TypedStepper<T>::update_stress(int group, int first, const MaterialParameters<V>& p,
                                                                 const V& dt, Mat3<V>& F, V& strength) const {
  const int common = store_.group_row[group];
  if (common >= 0) return update_branch(setup_.branches[common], p, dt, F, strength);
  // Lanes of several rows: evaluate every branch that occurs, and let each lane keep its own.
  alignas(64) T branch_of[W];
  bool present[kBranchCount] = {};
  for (int l = 0; l < W; ++l) {
    const int i = store_.particle[first + l];
    branch_of[l] = T(-1);
    if (i < 0) continue;
    const int branch = static_cast<int>(setup_.branches[setup_.row[i]]);
    branch_of[l] = T(branch);
    present[branch] = true;
  }
  const V lane_branch(branch_of, stdx::vector_aligned);
  const Mat3<V> trial = F;
  const V trial_strength = strength;
  Mat3<V> tau{};
  for (int branch = 0; branch < kBranchCount; ++branch) {
    if (!present[branch]) continue;
    Mat3<V> branch_F = trial;
    V branch_strength = trial_strength;
    const Mat3<V> branch_tau = update_branch(static_cast<Branch>(branch), p, dt, branch_F, branch_strength);
    const auto mine = lane_branch == V(T(branch));
    tau = select(mine, branch_tau, tau);
    F = select(mine, branch_F, F);
    strength = select(mine, branch_strength, strength);
  }
  return tau;
}

template <class T>
template <bool kGather, bool kScatter, bool kMeasure>
void TypedStepper<T>::process_block(int index, double dt) {
  alignas(64) T arena[kArenaNumbers];
  Crossing crossing;
  ParticleBlock& block = store_.map.particle_blocks[index];
  T* const out = grid_.arena(index);
  T* const force_free = kMeasure ? grid_.force_free_arena(index) : nullptr;
  if constexpr (kMeasure && kScatter) std::memset(force_free, 0, kArenaNumbers * sizeof(T));
  if (kGather) {
    grid_.load_velocities(block, arena);
  }
  if (kScatter) {
    for (int x = block.low[0]; x <= block.high[0]; ++x) {
      std::memset(out + 4 * kArena * (kArena * x + block.low[1]), 0,
                  sizeof(T) * 4 * kArena * (block.high[1] - block.low[1] + 1));
    }
  }
  BlockReport report;
  const T step = T(dt);
  const T move = T(dt / dx_), gradient = T(4 / dx_);
  const Vec3d origin = {kBlock * block.position[0] * dx_, kBlock * block.position[1] * dx_,
                        kBlock * block.position[2] * dx_};
  // Particles of blocks at the edge are held in the safe interior.
  T low[3], high[3];
  bool at_edge = false;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = T(kSafeCells - kBlock * block.position[axis]);
    high[axis] = T(setup_.domain.n - kSafeCells - kBlock * block.position[axis]);
    at_edge = at_edge || low[axis] > T(-2) || high[axis] < T(kBlock + 3);
  }
  V kinetic(T(0)), speed(T(0));
  V lowest[3] = {V(T(kBlock)), V(T(kBlock)), V(T(kBlock))}, highest[3] = {V(T(-1)), V(T(-1)), V(T(-1))};
  auto finite = V(T(0)) == V(T(0));

  // Base nodes are held inside the arena, so that no number whatsoever can lead a transfer outside it; where that
  // bites, the speed check ends the run.
  const auto locate_lanes = [](const Vec3<V>& x) {
    Place at;
    for (int axis = 0; axis < 3; ++axis) {
      at.base[axis] = at_most(at_least(round_down(x[axis] - T(0.5)), V(T(-1))), V(T(kBlock)));
      const V f = x[axis] - at.base[axis];
      const V l = T(1.5) - f, r = f - T(0.5);
      V* const w = at.weight[axis];
      w[0] = T(0.5) * l * l, w[2] = T(0.5) * r * r;
      w[1] = T(1) - w[0] - w[2];
      at.to_center[axis] = T(1) - f;
    }
    return at;
  };
  // Base nodes that the scattered particles reach; empty lanes do as well, without harm.
  const auto see_reach = [&](const Place& at) {
    for (int axis = 0; axis < 3; ++axis) {
      lowest[axis] = at_most(at.base[axis], lowest[axis]);
      highest[axis] = at_least(at.base[axis], highest[axis]);
    }
  };
  // One register of particles, from what it gathered to what it will scatter.
  const auto advance_lanes = [&](int first, Crossing& c) {
    const int group = first / W;
    Vec3<V> x, v;
    Mat3<V> F, C;
    for (int a = 0; a < 3; ++a) {
      x[a] = V(&store_.x[a][first], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) F[a][b] = V(&store_.F[3 * a + b][first], stdx::vector_aligned);
    }
    const MaterialParameters<V> p = group_parameters(group, first);
    const V volume(&store_.volume[first], stdx::vector_aligned);
    const V mass = p.density * volume;
    V strength = store_.has_strength ? V(&store_.strength[first], stdx::vector_aligned) : V(T(1));

    if (kGather) {
      const Place at = locate_lanes(x);
      records_to_lanes<T>(c.record, c.lanes);
      Mat3<V> moment;
      for (int a = 0; a < 3; ++a) {
        v[a] = V(c.lanes[1 + a], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) moment[a][b] = V(c.lanes[4 + 4 * b + 1 + a], stdx::vector_aligned);
      }
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) C[a][b] = gradient * (moment[a][b] + at.to_center[b] * v[a]);
      }
    } else {
      for (int a = 0; a < 3; ++a) {
        v[a] = V(&store_.v[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) C[a][b] = V(&store_.C[3 * a + b][first], stdx::vector_aligned);
      }
    }

    // Controls: the forced motion of the gathered substep, then blends and forces of the scattered one.
    const bool controlled = store_.group_controlled[group] != 0;
    const auto controls_of = [&](const ControlTable& table) {
      std::uint16_t groups[W];
      for (int l = 0; l < W; ++l) {
        const int i = store_.particle[first + l];
        groups[l] = i >= 0 ? setup_.control_group[i] : 0;
      }
      return load_controls<T>(table, groups, origin, dx_);
    };
    const bool forced = kGather && controlled && after_.active;
    ForcedMotion<V> motion;

    GroupMotion<V> measured;
    if (kMeasure) measured = {mass, volume, x, F, F, F, v, v, v, C, C, C};
    if (kGather) {
      if (forced) motion = force_motion<T>(controls_of(after_), x, mass, v, C, report.control_work);
      const V squared = dot(v, v);
      kinetic += mass * squared;
      speed = at_least(squared, speed);
      finite = finite && (squared - squared == V(T(0)));
      for (int a = 0; a < 3; ++a) x[a] += move * v[a];
      if (forced) {
        for (int a = 0; a < 3; ++a) x[a] += move * motion.increment[a];
        const Vec3<V> whole = v + motion.increment;
        speed = at_least(dot(whole, whole), speed);
      }
      if (at_edge) {
        const Vec3<V> free = x;
        for (int a = 0; a < 3; ++a) x[a] = at_most(at_least(x[a], V(low[a])), V(high[a]));
        const auto held = free.x != x.x || free.y != x.y || free.z != x.z;
        report.clamped += stdx::popcount(held && volume > V(T(0)));  // not the empty slots
      }
      const Mat3<V> gradient_of_step = forced ? C + motion.increment_gradient : C;
      F = F + V(step) * (gradient_of_step * F);
      if (setup_.track_total_F) {
        Mat3<V> total;
        for (int k = 0; k < 9; ++k) total[k / 3][k % 3] = V(&store_.total_F[k][first], stdx::vector_aligned);
        total = total + V(step) * (gradient_of_step * total);
        for (int k = 0; k < 9; ++k) total[k / 3][k % 3].copy_to(&store_.total_F[k][first], stdx::vector_aligned);
      }
    }
    // A prime pass only evaluates stress; its F has been through the return map already.
    if (kMeasure) measured.F_trial = F;
    const Mat3<V> tau = update_stress(group, first, p, V(kGather ? step : T(0)), F, strength);
    if (kMeasure) {
      measured.x = x, measured.v = v, measured.C = C;
      measured.v_moved = forced ? v + motion.increment : v;
      measured.C_moved = forced ? C + motion.increment_gradient : C;
      if (kGather) measured.F = F;
      Branch branch[W];
      for (int l = 0; l < W; ++l) {
        const int i = store_.particle[first + l];
        branch[l] = setup_.branches[setup_.row[i >= 0 ? i : store_.particle[first]]];  // groups begin with a particle
      }
      measure_group(measured, p, branch, origin, setup_.domain.gravity, dx_, kGather ? dt : 0, report.energy);
    }
    if (forced) report.control_work += elastic_work<T>(motion, tau, volume, step);
    if (kGather) {
      for (int a = 0; a < 3; ++a) {
        x[a].copy_to(&store_.x[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) F[a][b].copy_to(&store_.F[3 * a + b][first], stdx::vector_aligned);
      }
      if (store_.has_strength) strength.copy_to(&store_.strength[first], stdx::vector_aligned);
    }
    if (!kScatter) {
      for (int a = 0; a < 3; ++a) {
        v[a].copy_to(&store_.v[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) C[a][b].copy_to(&store_.C[3 * a + b][first], stdx::vector_aligned);
      }
      return;
    }

    if (controlled && before_.active) {
      report.control_work += blend_controls<T>(controls_of(before_), x, mass, v, C);
    }
    if (kMeasure) {
      const double scattered = affine_kinetic(mass, v, C, dx_);
      report.energy.control_before += scattered - affine_kinetic(mass, measured.v, measured.C, dx_);
      report.energy.scattered += scattered;
    }
    const Place at = locate_lanes(x);
    see_reach(at);
    // Per cell of offset: m C dx − dt V⁰ (4/dx) τ (MLS-MPM, Hu et al. 2018).
    const V inertia = mass * T(dx_), force = -(step * gradient) * volume;
    const Mat3<V> Q = inertia * C + force * tau;
    c.place(at);
    c.write(mass, mass * v + Q * at.to_center, Q);
    if (kMeasure) {
      const Mat3<V> spin = inertia * C;
      Crossing free;
      free.place(at);
      free.write(mass, mass * v + spin * at.to_center, spin);
      Row<T> own[9];
      for (auto& s : own) s = Row<T>::zero();
      for (int l = 0; l < W; ++l) {
        if (store_.particle[first + l] < 0) continue;
        free.scatter(own, l);
        flush_rows(own, force_free + free.offset[l]);
      }
    }
  };

  Row<T> sum[9];
  for (auto& s : sum) s = Row<T>::zero();
  int corner = -1;  // arena offset that `sum` belongs to
  const int end = block.begin + block.count;
  for (int first = block.begin; first < end; first += W) {
    const int real = std::min(W, end - first);
    store_.prefetch(first / W + kPrefetch);
    if (kGather) {
      Vec3<V> x;
      for (int a = 0; a < 3; ++a) x[a] = V(&store_.x[a][first], stdx::vector_aligned);
      crossing.place(locate_lanes(x));
      for (int l = 0; l < real; ++l) crossing.gather(arena, l);
      for (int l = real; l < W; ++l) std::memset(crossing.record[l], 0, sizeof(crossing.record[l]));
    }
    advance_lanes(first, crossing);
    if (!kScatter) continue;
    for (int l = 0; l < real; ++l) {
      if (crossing.offset[l] != corner) {
        if (corner >= 0) flush_rows(sum, out + corner);
        corner = crossing.offset[l];
      }
      crossing.scatter(sum, l);
    }
  }
  if (kScatter) {
    if (corner >= 0) flush_rows(sum, out + corner);
    for (int axis = 0; axis < 3; ++axis) {
      block.now_low[axis] = static_cast<std::int8_t>(stdx::hmin(lowest[axis]) + 1);
      block.now_high[axis] = static_cast<std::int8_t>(stdx::hmax(highest[axis]) + 3);
    }
  }
  report.kinetic = 0.5 * double(stdx::reduce(kinetic));
  report.max_speed_squared = double(stdx::hmax(speed));
  report.not_finite = !all(finite);
  reports_[index] = report;
}

template <class T>
template <bool kGather, bool kScatter>
void TypedStepper<T>::pass(double dt, StepReport& report) {
  const Stopwatch watch;
  const int count = static_cast<int>(store_.map.particle_blocks.size());
  if (setup_.measure_steps) {
    setup_.team->for_each(count, [&](int b) { process_block<kGather, kScatter, true>(b, dt); });
    ParticleEnergy energy;
    for (const BlockReport& r : reports_) energy.add(r.energy);
    kGather ? ledger_.finish(energy) : ledger_.begin(energy);
    report.energy = ledger_.total();
  } else {
    setup_.team->for_each(count, [&](int b) { process_block<kGather, kScatter, false>(b, dt); });
  }
  double kinetic = 0, speed_squared = 0;
  long long clamped = 0;
  for (const BlockReport& r : reports_) {
    kinetic += r.kinetic;
    report.control_work += r.control_work;
    speed_squared = std::max(speed_squared, r.max_speed_squared);
    clamped += r.clamped;
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

template <class T>
StepReport TypedStepper<T>::advance(int steps, double dt, const ControlSource& controls, double energy_limit) {
  StepReport report;
  if (steps <= 0 || store_.slots() == 0) return report;
  before_.active = controls(0, before_.group);
  pass<false, true>(dt, report);
  while (true) {
    update_grid(dt, report);
    std::swap(after_, before_);
    if (after_.active) {
      double enforced = 0, increment = 0;
      for (const Control& c : after_.group) {
        if (c.enforces()) enforced = std::max(enforced, c.top_speed());
        const double weight = std::max(c.position.along, c.position.across);
        if (weight > 0) increment = std::max(increment, weight * c.speed_limit);
      }
      // Motion that is enforced in one direction only keeps what it has in the others.
      next_drift_ = std::hypot(next_drift_, enforced * dt / dx_) + increment * dt / dx_;
    }
    if (drift_ > 0 && !(drift_ + next_drift_ <= kDriftLimit)) sort(report);
    const bool last = report.steps + 1 == steps;
    if (last) {
      pass<true, false>(dt, report);
    } else {
      before_.active = controls(report.steps + 1, before_.group);
      pass<true, true>(dt, report);
    }
    drift_ += next_drift_;
    ++report.steps;
    if (report.fault == StepFault::none && kinetic_ > energy_limit + 2 * report.control_work) {
      report.fault = StepFault::energy;
    }
    if (last || report.fault != StepFault::none) return report;
  }
}

}  // namespace

std::unique_ptr<Stepper> make_stepper(Precision precision, const StepperSetup& setup) {
  if (precision == Precision::full) return std::make_unique<TypedStepper<double>>(setup);
  return std::make_unique<TypedStepper<float>>(setup);
}

}  // namespace physmas::mpm
