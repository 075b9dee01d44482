// What one substep does with the particles of one block: gather from the grid, move, deform, evaluate stress, scatter.
#ifndef PHYSMAS_MPM_BLOCK_PASS_H
#define PHYSMAS_MPM_BLOCK_PASS_H

#include <cstring>
#include <type_traits>

#include "mpm/apply_control.h"
#include "mpm/constitutive.h"
#include "mpm/energy_budget.h"
#include "mpm/grid.h"
#include "mpm/particle_store.h"

namespace physmas::mpm {

// Particles stay this many cells away from the edge of the grid, inside the domain walls: every node of a stencil
// exists.
constexpr double kSafeCells = 2;
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
            Grid<T>& grid, const ControlTable& before, const ControlTable& after)
      : setup_(setup), parameters_(parameters), store_(store), grid_(grid), before_(before), after_(after) {}

  // Block `index` of the store's map. kGather: ends a substep of dt [s] (`after` are its controls); kScatter: begins
  // one
  // (`before`); kMeasure: the energies. next: the block whose nodes to fetch meanwhile, or -1.
  template <bool kGather, bool kScatter, bool kMeasure>
  BlockReport run(int index, int next, double dt);

 private:
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;
  static_assert(W == Row<T>::kPart);

  MaterialParameters<V> group_parameters(int group, int first) const;
  Mat3<V> update_stress(int group, int first, const MaterialParameters<V>& p, const V& dt, Mat3<V>& F,
                        V& strength) const;

  const StepperSetup& setup_;
  const std::vector<MaterialParameters<T>>& parameters_;
  ParticleStore<T>& store_;
  Grid<T>& grid_;
  const ControlTable &before_, &after_;
};

// Parameters of the lanes of a group: the same in all lanes unless rows are mixed.
template <class T>
MaterialParameters<typename BlockPass<T>::V> BlockPass<T>::group_parameters(int group, int first) const {
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
Mat3<typename BlockPass<T>::V> BlockPass<T>::update_stress(int group, int first, const MaterialParameters<V>& p,
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
BlockReport BlockPass<T>::run(int index, int next, double dt) {
  const ParticleBlock& block = store_.map.particle_blocks[index];
  GridExchange<T> exchange(grid_.layout);
  // Carries what the forces have no part in; only where energies are measured.
  std::conditional_t<kMeasure, GridExchange<T>, const GridLayout&> free(grid_.layout);
  BlockReport report;
  const double dx = setup_.domain.dx();
  const T step = T(dt);
  const T move = T(dt / dx), gradient = T(4 / dx);
  const Vec3d origin = {kBlock * block.position[0] * dx, kBlock * block.position[1] * dx,
                        kBlock * block.position[2] * dx};
  // Particles of blocks at the edge are held in the safe interior.
  T low[3], high[3];
  bool at_edge = false;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = T(kSafeCells - kBlock * block.position[axis]);
    high[axis] = T(setup_.domain.n - kSafeCells - kBlock * block.position[axis]);
    at_edge = at_edge || low[axis] > T(-2) || high[axis] < T(kBlock + 3);
  }
  V kinetic(T(0)), speed(T(0));
  auto finite = V(T(0)) == V(T(0));

  // One register of particles, from the grid and back to it. Where all its particles are of one branch, and nothing but
  // the material acts on them, that is known when this is compiled and numbers stay in registers.
  const auto advance_lanes = [&](int group, auto known_branch) PHYSMAS_LAMBDA_INLINE {
    constexpr int kKnown = decltype(known_branch)::value;
    constexpr bool kPlain = kKnown >= 0;
    constexpr bool kStrength = !kPlain || kKnown == static_cast<int>(Branch::plasticine);
    const int first = group * W;
    T* const numbers = store_.numbers(group);
    const auto number = [&](int channel) { return V(numbers + channel * W, stdx::vector_aligned); };
    Vec3<V> x, v;
    Mat3<V> F, C;
    for (int a = 0; a < 3; ++a) {
      x[a] = number(a);
      for (int b = 0; b < 3; ++b) F[a][b] = number(store_.kDeformation + 3 * a + b);
    }
    const LaneBits lanes = store_.group_lanes[group];
    const int column = store_.group_column[group];
    const MaterialParameters<V> p =
        kPlain ? convert_parameters<V>(parameters_[store_.group_row[group]]) : group_parameters(group, first);
    const V volume = number(store_.kVolume);
    const V mass = p.density * volume;
    V strength = kStrength && store_.has_strength ? V(&store_.strength[first], stdx::vector_aligned) : V(T(1));

    if (kGather) {
      const Place<V> at = place_of(x);
      Mat3<V> moment;
      exchange.gather(grid_.velocity(block), at, column, lanes, v, moment);
      const auto real = volume > V(T(0));
      for (int a = 0; a < 3; ++a) {
        v[a] = select(real, v[a], V(T(0)));
        for (int b = 0; b < 3; ++b) {
          C[a][b] = select(real, gradient * (moment[a][b] + at.to_center[b] * v[a]), V(T(0)));
        }
      }
    } else {
      for (int a = 0; a < 3; ++a) {
        v[a] = V(&store_.v[a][first], stdx::vector_aligned);
        for (int b = 0; b < 3; ++b) C[a][b] = V(&store_.C[3 * a + b][first], stdx::vector_aligned);
      }
    }

    // Controls: the forced motion of the gathered substep, then blends and forces of the scattered one.
    const bool controlled = !kPlain && store_.group_controlled[group] != 0;
    const auto controls_of = [&](const ControlTable& table) {
      std::uint16_t groups[W];
      for (int l = 0; l < W; ++l) {
        const int i = store_.particle[first + l];
        groups[l] = i >= 0 ? setup_.control_group[i] : 0;
      }
      return load_controls<T>(table, groups, origin, dx);
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
        const Vec3<V> moved = x;
        for (int a = 0; a < 3; ++a) x[a] = at_most(at_least(x[a], V(low[a])), V(high[a]));
        const auto held = moved.x != x.x || moved.y != x.y || moved.z != x.z;
        report.clamped += stdx::popcount(held && volume > V(T(0)));
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
    const V evolved(kGather ? step : T(0));
    const Mat3<V> tau = kPlain ? update_branch(static_cast<Branch>(kKnown), p, evolved, F, strength)
                               : update_stress(group, first, p, evolved, F, strength);
    if (kMeasure) {
      measured.x = x, measured.v = v, measured.C = C;
      measured.v_moved = forced ? v + motion.increment : v;
      measured.C_moved = forced ? C + motion.increment_gradient : C;
      if (kGather) measured.F = F;
      Branch branch[W];
      for (int l = 0; l < W; ++l) {
        const int i = store_.particle[first + l];
        branch[l] = setup_.branches[i >= 0 ? setup_.row[i] : 0];
      }
      measure_group(measured, p, branch, origin, setup_.domain.gravity, dx, kGather ? dt : 0, report.energy);
    }
    if (forced) report.control_work += elastic_work<T>(motion, tau, volume, step);
    if (kGather) {
      for (int a = 0; a < 3; ++a) {
        x[a].copy_to(numbers + a * W, stdx::vector_aligned);
        for (int b = 0; b < 3; ++b)
          F[a][b].copy_to(numbers + (store_.kDeformation + 3 * a + b) * W, stdx::vector_aligned);
      }
      if (kStrength && store_.has_strength) strength.copy_to(&store_.strength[first], stdx::vector_aligned);
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
      const double scattered = affine_kinetic(mass, v, C, dx);
      report.energy.control_before += scattered - affine_kinetic(mass, measured.v, measured.C, dx);
      report.energy.scattered += scattered;
    }
    const Place<V> at = place_of(x);
    // Per cell of offset: m C dx − dt V⁰ (4/dx) τ (MLS-MPM, Hu et al. 2018).
    const V inertia = mass * T(dx), force = -(step * gradient) * volume;
    const Mat3<V> Q = inertia * C + force * tau;
    exchange.scatter(grid_.momentum(block), at, column, lanes, mass, mass * v + Q * at.to_center, Q);
    if constexpr (kMeasure) {
      const Mat3<V> spin = inertia * C;
      free.scatter(grid_.force_free(block), at, column, lanes, mass, mass * v + spin * at.to_center, spin);
    }
  };

  for (int group = block.begin / W; group < (block.begin + block.slots) / W; ++group) {
    store_.prefetch(group + kPrefetch);
    if (next >= 0) {
      grid_.prefetch(store_.map.particle_blocks[next], group - block.begin / W, block.slots / W);
    }
    const int row = store_.group_row[group];
    const bool controlled = store_.group_controlled[group] && (before_.active || after_.active);
    if (kGather && kScatter && !kMeasure && row >= 0 && !controlled) {
      with_branch(setup_.branches[row], [&](auto branch) PHYSMAS_LAMBDA_INLINE { advance_lanes(group, branch); });
    } else {
      advance_lanes(group, std::integral_constant<int, -1>());
    }
  }
  if (kScatter) exchange.flush(grid_.momentum(block));
  if constexpr (kMeasure && kScatter) free.flush(grid_.force_free(block));
  report.strays = exchange.strays();
  report.kinetic = 0.5 * double(stdx::reduce(kinetic));
  report.max_speed_squared = double(stdx::hmax(speed));
  report.not_finite = !all(finite);
  return report;
}

}  // namespace physmas::mpm

#endif
