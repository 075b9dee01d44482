// What one substep does with the particles of one block: gather from the grid, move, deform, evaluate stress, scatter.
#ifndef PHYSMAS_MPM_CPU_BLOCK_PASS_H
#define PHYSMAS_MPM_CPU_BLOCK_PASS_H

#include <type_traits>

#include "mpm/action/apply_control.h"
#include "mpm/cpu/grid.h"
#include "mpm/cpu/measure_energy.h"
#include "mpm/cpu/particle_store.h"
#include "mpm/material/constitutive.h"

namespace physmas::mpm {

// Particles stay this many cells away from the edge of the grid, inside the domain walls: every node of a stencil
// exists.
constexpr double kSafeCells = 2;
// A strength [Pa] that no stress reaches; fits every type.
constexpr double kNeverYields = 1e30;
// Registers of particles that are fetched ahead.
constexpr int kPrefetch = 2;

// What one block reports from one pass; summed in block order, so totals do not depend on the threads.
struct BlockReport {
  double kinetic = 0;       // J
  double control_work = 0;  // J
  double max_speed_squared = 0;
  int clamped = 0, strays = 0;
  bool not_finite = false;
  ParticleEnergy energy;  // when measured
};

// Calls function with the branch as a constant.
template <class Function>
PHYSMAS_INLINE void with_branch(Branch branch, const Function& function) {
  switch (branch) {
    case Branch::jelly:
      return function(std::integral_constant<int, static_cast<int>(Branch::jelly)>());
    case Branch::metal:
      return function(std::integral_constant<int, static_cast<int>(Branch::metal)>());
    case Branch::sand:
      return function(std::integral_constant<int, static_cast<int>(Branch::sand)>());
    case Branch::foam:
      return function(std::integral_constant<int, static_cast<int>(Branch::foam)>());
    case Branch::snow:
      return function(std::integral_constant<int, static_cast<int>(Branch::snow)>());
    case Branch::plasticine:
      return function(std::integral_constant<int, static_cast<int>(Branch::plasticine)>());
  }
}

template <class T>
class BlockPass {
 public:
  // All of them outlive the pass.
  BlockPass(const StepperSetup& setup, const std::vector<MaterialParameters<T>>& parameters, ParticleStore<T>& store,
            Grid<T>& grid, const RigidMotion& rigid, const ControlTable& before, const ControlTable& after)
      : setup_(setup),
        parameters_(parameters),
        store_(store),
        grid_(grid),
        rigid_(rigid),
        before_(before),
        after_(after) {}

  // Block `index` of the store's map. kGather: ends a substep of dt [s] (`after` are its controls); kScatter: begins
  // one (`before`); kMeasure: the energies.
  template <bool kGather, bool kScatter, bool kMeasure>
  BlockReport run(int index, double dt);

 private:
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;
  static_assert(W == NodeRow<T>::kPart);

  struct Run;
  struct LaneState;
  struct Rows;
  LaneControls<T> controls_of(const Run& run, int reg, const ControlTable& table) const;
  void move(Run& run, int reg, bool forced, const ForcedMotion<V>& motion, LaneState& s) const;
  template <bool kMeasure>
  LaneBits set_scattered(Run& run, int reg, int column, const LaneState& s, const Mat3<V>& tau,
                         GridNumbers<T>& numbers) const;
  template <int kKnown, bool kGather, bool kScatter, bool kMeasure>
  LaneBits advance(Run& run, int reg, int column, GridNumbers<T>& numbers);
  template <bool kGather, bool kScatter, bool kMeasure>
  LaneBits advance_rigid(Run& run, int reg, int column, GridNumbers<T>& numbers);
  static void scatter_strays(const GridExchange<T>& exchange, T* nodes, const T* x, int column, LaneBits lanes,
                             GridNumbers<T>& numbers);
  Rows rows_of(int reg) const;
  MaterialParameters<V> parameters_of(const Rows& rows) const;
  // own: of the lanes, null where they have their rows'.
  Mat3<V> update_stress(const Rows& rows, const ParticleElasticity<V>* own, const V& dt, Mat3<V>& F, V& strength) const;

  const StepperSetup& setup_;
  const std::vector<MaterialParameters<T>>& parameters_;
  ParticleStore<T>& store_;
  Grid<T>& grid_;
  const RigidMotion& rigid_;
  const ControlTable &before_, &after_;
};

// The rows whose particles a register holds.
template <class T>
struct BlockPass<T>::Rows {
  int count = 0, row[W] = {};
  LaneBits lanes[W];

  void add(int new_row, LaneBits its_lanes) {
    int k = 0;
    while (k < count && row[k] != new_row) ++k;
    if (k == count) {
      row[count] = new_row;
      lanes[count++] = 0;
    }
    lanes[k] |= its_lanes;
  }
};

template <class T>
typename BlockPass<T>::Rows BlockPass<T>::rows_of(int reg) const {
  Rows rows;
  if (store_.registers[reg].row >= 0) {
    rows.add(store_.registers[reg].row, kAllLanes<T>);
  } else {
    for (int l = 0; l < W; ++l) {
      const int i = store_.particle[reg * W + l];
      if (i >= 0) rows.add(setup_.row[i], LaneBits(1) << l);
    }
  }
  return rows;
}

// Parameters lane by lane.
template <class T>
PHYSMAS_INLINE MaterialParameters<typename BlockPass<T>::V> BlockPass<T>::parameters_of(const Rows& rows) const {
  MaterialParameters<V> p = convert_parameters<V>(parameters_[rows.row[0]]);
  for (int k = 1; k < rows.count; ++k) {
    p = select(lane_mask<T>(rows.lanes[k]), convert_parameters<V>(parameters_[rows.row[k]]), p);
  }
  return p;
}

template <class T>
Mat3<typename BlockPass<T>::V> BlockPass<T>::update_stress(const Rows& rows, const ParticleElasticity<V>* own,
                                                           const V& dt, Mat3<V>& F, V& strength) const {
  // Every row's own law for all lanes, of which its own are kept.
  const Mat3<V> trial = F;
  const V trial_strength = strength;
  Mat3<V> tau{};
  for (int k = 0; k < rows.count; ++k) {
    Mat3<V> row_F = trial;
    V row_strength = trial_strength;
    MaterialParameters<V> p = convert_parameters<V>(parameters_[rows.row[k]]);
    if (own) p = with_elasticity(p, *own);
    const Mat3<V> row_tau = update_branch(setup_.branches[rows.row[k]], p, dt, row_F, row_strength);
    const auto mine = lane_mask<T>(rows.lanes[k]);
    tau = select(mine, row_tau, tau);
    F = select(mine, row_F, F);
    strength = select(mine, row_strength, strength);
  }
  return tau;
}

// What the registers of one block have in common during a pass, and what they add up.
template <class T>
struct BlockPass<T>::Run {
  const int index;
  const ParticleBlock& block;
  const double dt, dx;
  const T move, step, gradient;  // cells per m/s, s, 1/cells of a first moment
  const Vec3d origin;
  bool at_edge = false;  // particles are held in the safe interior
  bool leaving = false;  // some particles have left their column's cell
  T low[3], high[3];
  BlockReport report;
  V kinetic = V(T(0)), speed_squared = V(T(0));
  // Between gathering and scattering; and what is scattered without the forces' part, where energies are measured.
  GridNumbers<T> numbers[kColumnBatch], force_free;

  Run(int block_index, const ParticleBlock& particles, const Domain& domain, double seconds)
      : index(block_index),
        block(particles),
        dt(seconds),
        dx(domain.dx()),
        move(T(dt / dx)),
        step(T(dt)),
        gradient(T(4 / dx)),
        origin{kBlock * block.position[0] * dx, kBlock * block.position[1] * dx, kBlock * block.position[2] * dx} {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = T(kSafeCells - kBlock * block.position[axis]);
      high[axis] = T(domain.n - kSafeCells - kBlock * block.position[axis]);
      at_edge = at_edge || low[axis] > T(-2) || high[axis] < T(kBlock + 3);
    }
  }
};

// The particles of a register during a pass.
template <class T>
struct BlockPass<T>::LaneState {
  Vec3<V> x, v;
  Mat3<V> F, C;
  V volume, mass, strength;
};

template <class T>
PHYSMAS_INLINE LaneControls<T> BlockPass<T>::controls_of(const Run& run, int reg, const ControlTable& table) const {
  const auto& common = store_.registers[reg];
  if (common.control != store_.kSeveral) {
    return load_controls<T>(table.group[common.control], common.lanes, run.origin, run.dx);
  }
  std::uint16_t groups[W];
  for (int l = 0; l < W; ++l) {
    const int i = store_.particle[reg * W + l];
    groups[l] = i >= 0 ? setup_.control_group[i] : 0;
  }
  return load_controls<T>(table, groups, run.origin, run.dx);
}

// Moves and deforms a register by a substep. forced: with `motion` on top of what was gathered.
template <class T>
PHYSMAS_INLINE void BlockPass<T>::move(Run& run, int reg, bool forced, const ForcedMotion<V>& motion,
                                       LaneState& s) const {
  const V squared = dot(s.v, s.v);
  run.kinetic += s.mass * squared;
  run.speed_squared = at_least(squared, run.speed_squared);
  for (int a = 0; a < 3; ++a) s.x[a] += run.move * s.v[a];
  if (forced) {
    for (int a = 0; a < 3; ++a) s.x[a] += run.move * motion.increment[a];
    const Vec3<V> whole = s.v + motion.increment;
    run.speed_squared = at_least(dot(whole, whole), run.speed_squared);
  }
  if (run.at_edge) {
    const Vec3<V> moved = s.x;
    for (int a = 0; a < 3; ++a) s.x[a] = at_most(at_least(s.x[a], V(run.low[a])), V(run.high[a]));
    const auto held = moved.x != s.x.x || moved.y != s.x.y || moved.z != s.x.z;
    run.report.clamped += stdx::popcount(held && s.volume > V(T(0)));
  }
  const Mat3<V> gradient = forced ? s.C + motion.increment_gradient : s.C;
  s.F = s.F + V(run.step) * (gradient * s.F);
  if (setup_.track_total_F) {
    Mat3<V> total;
    for (int k = 0; k < 9; ++k) total[k / 3][k % 3] = V(&store_.total_F[k][reg * W], stdx::vector_aligned);
    total = total + V(run.step) * (gradient * total);
    for (int k = 0; k < 9; ++k) total[k / 3][k % 3].copy_to(&store_.total_F[k][reg * W], stdx::vector_aligned);
  }
}

// What goes to the grid: momenta, MLS forces (Hu et al. 2018) and weights. Returns the lanes that are not in their cell
// of the column any more.
template <class T>
template <bool kMeasure>
PHYSMAS_INLINE LaneBits BlockPass<T>::set_scattered(Run& run, int reg, int column, const LaneState& s,
                                                    const Mat3<V>& tau, GridNumbers<T>& numbers) const {
  const Place<V> at = place_of(s.x, column >= 0 ? GridExchange<T>::column_base(column) : base_of(s.x));
  numbers.set_weights(at);
  // Per cell of offset: m C dx − dt V⁰ (4/dx) τ.
  const V inertia = s.mass * T(run.dx), force = -(run.step * run.gradient) * s.volume;
  const Mat3<V> Q = inertia * s.C + force * tau;
  numbers.set(s.mass, s.mass * s.v + Q * at.to_center, Q);
  if (kMeasure) {
    const Mat3<V> spin = inertia * s.C;
    run.force_free.set_weights(at);
    run.force_free.set(s.mass, s.mass * s.v + spin * at.to_center, spin);
  }
  return column >= 0 ? lane_bits(strayed(at)) & store_.registers[reg].lanes : 0;
}

// One register of particles, from `numbers` and back to them. column: its column's cell, or -1. kKnown: its branch,
// where all its particles are of one and nothing but the material acts on them, so that numbers stay in registers; else
// -1. Returns the lanes that are not in their cell of the column any more; their numbers are as if they were.
template <class T>
template <int kKnown, bool kGather, bool kScatter, bool kMeasure>
LaneBits BlockPass<T>::advance(Run& run, int reg, int column, GridNumbers<T>& numbers) {
  constexpr bool kPlain = kKnown >= 0;
  constexpr bool kStrength = !kPlain || kKnown == static_cast<int>(Branch::plasticine);
  const int first = reg * W;
  T* const state = store_.numbers(reg);
  const auto number = [&](int channel) { return V(state + channel * W, stdx::vector_aligned); };
  const auto put = [&](int channel, const V& lanes) { lanes.copy_to(state + channel * W, stdx::vector_aligned); };
  LaneState s;
  for (int a = 0; a < 3; ++a) {
    s.x[a] = number(a);
    for (int b = 0; b < 3; ++b) s.F[a][b] = number(store_.kDeformation + 3 * a + b);
  }
  const Rows rows = kPlain ? Rows() : rows_of(reg);
  MaterialParameters<V> p =
      kPlain ? convert_parameters<V>(parameters_[store_.registers[reg].row]) : parameters_of(rows);
  ParticleElasticity<V> own;
  if (store_.has_elasticity) {
    const auto lanes = [&](int k) { return V(&store_.elasticity[k][first], stdx::vector_aligned); };
    own = {lanes(0), lanes(1), lanes(2)};
    p = with_elasticity(p, own);
  }
  s.volume = number(store_.kVolume);
  s.mass = p.density * s.volume;
  s.strength = kStrength && store_.has_strength ? V(&store_.strength[first], stdx::vector_aligned) : V(T(1));
  // Without a step the stress alone is asked for. F has been through the return map already: where that has softened
  // Plasticine, it would yield a second time.
  if (!kGather) s.strength = V(T(kNeverYields));
  for (int a = 0; a < 3; ++a) {
    s.v[a] = kGather ? numbers.get(numbers.vector(a)) : V(&store_.v[a][first], stdx::vector_aligned);
    for (int b = 0; b < 3; ++b) {
      s.C[a][b] = kGather ? run.gradient * numbers.get(numbers.matrix(a, b))
                          : V(&store_.C[3 * a + b][first], stdx::vector_aligned);
    }
  }

  // Controls: the forced motion of the gathered substep, then blends and forces of the scattered one.
  const bool controlled = !kPlain && store_.registers[reg].control != 0;
  const bool forced = kGather && controlled && after_.active;
  ForcedMotion<V> motion;
  RegisterMotion<V> measured;
  if (kMeasure) measured = {s.mass, s.volume, s.x, s.F, s.F, s.F, s.v, s.v, s.v, s.C, s.C, s.C};
  if (kGather) {
    if (forced) {
      motion = force_motion<T>(controls_of(run, reg, after_), s.x, s.mass, s.v, s.C, run.report.control_work);
    }
    move(run, reg, forced, motion, s);
  }

  if (kMeasure) measured.F_trial = s.F;
  const V evolved(kGather ? run.step : T(0));
  const Mat3<V> tau = kPlain ? update_branch(static_cast<Branch>(kKnown), p, evolved, s.F, s.strength)
                             : update_stress(rows, store_.has_elasticity ? &own : nullptr, evolved, s.F, s.strength);
  if (kMeasure) {
    measured.x = s.x, measured.v = s.v, measured.C = s.C;
    measured.v_moved = forced ? s.v + motion.increment : s.v;
    measured.C_moved = forced ? s.C + motion.increment_gradient : s.C;
    if (kGather) measured.F = s.F;
    Branch branch[W];
    for (int l = 0; l < W; ++l) {
      const int i = store_.particle[first + l];
      branch[l] = setup_.branches[i >= 0 ? setup_.row[i] : 0];
    }
    measure_register(measured, p, branch, run.origin, setup_.domain.gravity, run.dx, kGather ? run.dt : 0,
                     run.report.energy);
  }
  if (forced) run.report.control_work += elastic_work<T>(motion, tau, s.volume, run.step);

  if (kGather) {
    for (int a = 0; a < 3; ++a) {
      put(a, s.x[a]);
      for (int b = 0; b < 3; ++b) put(store_.kDeformation + 3 * a + b, s.F[a][b]);
    }
    if (kStrength && store_.has_strength) s.strength.copy_to(&store_.strength[first], stdx::vector_aligned);
  }
  if (!kScatter) {
    for (int a = 0; a < 3; ++a) {
      s.v[a].copy_to(&store_.v[a][first], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) s.C[a][b].copy_to(&store_.C[3 * a + b][first], stdx::vector_aligned);
    }
    return 0;
  }

  if (controlled && before_.active) {
    run.report.control_work += blend_controls<T>(controls_of(run, reg, before_), s.x, s.mass, s.v, s.C);
  }
  if (kMeasure) {
    const double scattered = affine_kinetic(s.mass, s.v, s.C, run.dx);
    run.report.energy.control_before += scattered - affine_kinetic(s.mass, measured.v, measured.C, run.dx);
    run.report.energy.scattered += scattered;
  }
  return set_scattered<kMeasure>(run, reg, column, s, tau, numbers);
}

// A register of a rigid body (mpm/rigid), whose motion is known: no gather and no stress.
template <class T>
template <bool kGather, bool kScatter, bool kMeasure>
LaneBits BlockPass<T>::advance_rigid(Run& run, int reg, int column, GridNumbers<T>& numbers) {
  const int first = reg * W, body = store_.registers[reg].body - 1;
  const RigidBody& motion = rigid_.body(body);
  const Vec3d& velocity = motion.motion.velocity;
  const Vec3d& spin = motion.motion.spin;
  T* const state = store_.numbers(reg);
  alignas(64) T x[3][W], v[3][W];
  for (int l = 0; l < W; ++l) {
    const int i = store_.particle[first + l];
    if (i < 0) {
      for (int a = 0; a < 3; ++a) x[a][l] = state[a * W + l], v[a][l] = T(0);
      continue;
    }
    const Vec3d d = motion.rotation * setup_.rigid.offset[i];
    const Vec3d u = velocity + cross(spin, d);
    const Vec3d at = motion.center + d - run.origin;
    for (int a = 0; a < 3; ++a) {
      x[a][l] = kGather ? T(at[a] / run.dx) : state[a * W + l];
      v[a][l] = T(u[a]);
    }
  }
  LaneState s;
  const Rows rows = store_.registers[reg].row >= 0 ? Rows() : rows_of(reg);
  MaterialParameters<V> p = store_.registers[reg].row >= 0
                                ? convert_parameters<V>(parameters_[store_.registers[reg].row])
                                : parameters_of(rows);
  if (store_.has_elasticity) {
    const auto lanes = [&](int k) { return V(&store_.elasticity[k][first], stdx::vector_aligned); };
    p = with_elasticity(p, {lanes(0), lanes(1), lanes(2)});
  }
  s.volume = V(state + store_.kVolume * W, stdx::vector_aligned);
  s.mass = p.density * s.volume;
  const T turn[3] = {T(spin.x), T(spin.y), T(spin.z)};
  for (int a = 0; a < 3; ++a) {
    s.x[a] = V(x[a], stdx::vector_aligned);
    s.v[a] = V(v[a], stdx::vector_aligned);
    s.C[a][a] = V(T(0));
    s.C[a][(a + 1) % 3] = V(-turn[(a + 2) % 3]);
    s.C[a][(a + 2) % 3] = V(turn[(a + 1) % 3]);
  }
  if (kGather) {
    const V squared = dot(s.v, s.v);
    run.kinetic += s.mass * squared;
    run.speed_squared = at_least(squared, run.speed_squared);
    if (run.at_edge) {
      const Vec3<V> moved = s.x;
      for (int a = 0; a < 3; ++a) s.x[a] = at_most(at_least(s.x[a], V(run.low[a])), V(run.high[a]));
      const auto held = moved.x != s.x.x || moved.y != s.x.y || moved.z != s.x.z;
      run.report.clamped += stdx::popcount(held && s.volume > V(T(0)));
    }
    for (int a = 0; a < 3; ++a) s.x[a].copy_to(state + a * W, stdx::vector_aligned);
  }
  if (kMeasure) {
    Mat3<V> F;
    for (int k = 0; k < 9; ++k) F[k / 3][k % 3] = V(state + (store_.kDeformation + k) * W, stdx::vector_aligned);
    Branch branch[W];
    for (int l = 0; l < W; ++l) {
      const int i = store_.particle[first + l];
      branch[l] = setup_.branches[i >= 0 ? setup_.row[i] : 0];
    }
    const RegisterMotion<V> measured = {s.mass, s.volume, s.x, F, F, F, s.v, s.v, s.v, s.C, s.C, s.C};
    measure_register(measured, p, branch, run.origin, setup_.domain.gravity, run.dx, 0, run.report.energy);
    const double kinetic = affine_kinetic(s.mass, s.v, s.C, run.dx);
    if (kGather) run.report.energy.gathered += kinetic, run.report.energy.rigid += kinetic;
  }
  if (!kScatter) {
    for (int a = 0; a < 3; ++a) {
      s.v[a].copy_to(&store_.v[a][first], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) s.C[a][b].copy_to(&store_.C[3 * a + b][first], stdx::vector_aligned);
    }
    return 0;
  }
  const double rest = kMeasure ? affine_kinetic(s.mass, s.v, s.C, run.dx) : 0;
  if (store_.registers[reg].control != 0 && before_.active) {
    run.report.control_work += blend_controls<T>(controls_of(run, reg, before_), s.x, s.mass, s.v, s.C);
  }
  if (kMeasure) {
    const double scattered = affine_kinetic(s.mass, s.v, s.C, run.dx);
    run.report.energy.control_before += scattered - rest;
    run.report.energy.scattered += scattered;
  }
  const V nothing(T(0));
  return set_scattered<kMeasure>(run, reg, column, s, diagonal(nothing, nothing, nothing), numbers);
}

// Carries lanes that have left their column's cell to the grid, and takes them out of the numbers that go there with
// the column.
template <class T>
void BlockPass<T>::scatter_strays(const GridExchange<T>& exchange, T* nodes, const T* x, int column, LaneBits lanes,
                                  GridNumbers<T>& numbers) {
  const Vec3<V> at = GridExchange<T>::load(x);
  const Vec3<V> base = base_of(at);
  const Vec3<V> shift = base - GridExchange<T>::column_base(column);
  GridNumbers<T> strays;
  strays.set_weights(place_of(at, base));
  Vec3<V> momentum, none;
  Mat3<V> Q;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) Q[a][b] = numbers.get(numbers.matrix(a, b));
    momentum[a] = numbers.get(numbers.vector(a));
    none[a] = V(T(0));
  }
  // P belongs to the centre node.
  strays.set(numbers.get(numbers.kMass), momentum + Q * shift, Q);
  exchange.scatter_particles(nodes, x, lanes, strays);
  const auto gone = lane_mask<T>(lanes);
  numbers.set(select(gone, V(T(0)), numbers.get(numbers.kMass)), select(gone, none, momentum),
              select(gone, Mat3<V>{{none, none, none}}, Q));
}

template <class T>
template <bool kGather, bool kScatter, bool kMeasure>
BlockReport BlockPass<T>::run(int index, double dt) {
  const ParticleBlock& block = store_.map.particle_blocks[index];
  const GridExchange<T> exchange(grid_.layout);
  Run run(index, block, setup_.domain, dt);
  const bool some_rigid = rigid_.held() && block.bodies > 1u;
  const auto advance_any = [&](int reg, int column, GridNumbers<T>& numbers) PHYSMAS_LAMBDA_INLINE {
    if (some_rigid && store_.registers[reg].body > 0)
      return advance_rigid<kGather, kScatter, kMeasure>(run, reg, column, numbers);
    const int row = store_.registers[reg].row;
    const bool controlled = store_.registers[reg].control != 0 && (before_.active || after_.active);
    if (kGather && kScatter && !kMeasure && row >= 0 && !controlled) {
      LaneBits strays = 0;
      with_branch(setup_.branches[row], [&](auto branch) PHYSMAS_LAMBDA_INLINE {
        strays = advance<decltype(branch)::value, true, true, false>(run, reg, column, numbers);
      });
      return strays;
    }
    return advance<-1, kGather, kScatter, kMeasure>(run, reg, column, numbers);
  };

  const int begin = block.begin / W, end = begin + block.slots / W;
  for (int reg = begin, count = 1; reg < end; reg += count, count = 1) {
    const int column = store_.registers[reg].column, body = store_.registers[reg].body;
    while (column >= 0 && count < kColumnBatch && reg + count < end && store_.registers[reg + count].column == column &&
           store_.registers[reg + count].body == body) {
      ++count;
    }
    // What is rigid moves without asking the grid.
    const bool gathers = kGather && !(some_rigid && body > 0);
    const T* const velocity = grid_.velocity(block, body);
    T* const momentum = grid_.momentum(block, body);
    LaneBits lanes[kColumnBatch];
    const T* x[kColumnBatch];
    for (int r = 0; r < count; ++r) {
      store_.prefetch(reg + r + kPrefetch);
      lanes[r] = store_.registers[reg + r].lanes;
      x[r] = store_.numbers(reg + r);
    }
    if (column < 0) {
      if (lanes[0] == 0) continue;
      if (gathers) exchange.gather_particles(velocity, x[0], lanes[0], run.numbers[0]);
      advance_any(reg, column, run.numbers[0]);
      if (kScatter) exchange.scatter_particles(momentum, x[0], lanes[0], run.numbers[0]);
      if (kMeasure && kScatter)
        exchange.scatter_particles(grid_.force_free(block, body), x[0], lanes[0], run.force_free);
      continue;
    }
    if (gathers) exchange.gather_columns(velocity, column, count, x, lanes, run.numbers);
    for (int r = 0; r < count; ++r) {
      const LaneBits strays = advance_any(reg + r, column, run.numbers[r]);
      if (!kScatter) continue;
      if (strays != 0) {
        scatter_strays(exchange, momentum, x[r], column, strays, run.numbers[r]);
        if (kMeasure) scatter_strays(exchange, grid_.force_free(block, body), x[r], column, strays, run.force_free);
        store_.registers[reg + r].leaving = strays;
        run.leaving = true;
      }
      if (kMeasure) exchange.scatter_columns(grid_.force_free(block, body), column, 1, &run.force_free);
    }
    if (kScatter) exchange.scatter_columns(momentum, column, count, run.numbers);
  }
  if (run.leaving) store_.leave_columns(index);
  BlockReport report = run.report;
  report.strays = block.strayed;
  report.kinetic = 0.5 * double(stdx::reduce(run.kinetic));
  report.max_speed_squared = double(stdx::hmax(run.speed_squared));
  report.not_finite = !std::isfinite(report.kinetic);
  return report;
}

}  // namespace physmas::mpm

#endif
