#include "mpm/cpu/state_summary.h"

#include <algorithm>
#include <limits>

#include "mpm/material/stiffness.h"
#include "mpm/math/lanes.h"

namespace physmas::mpm {

namespace {

// Particles per partial result: fixed, so that what is summed does not depend on the threads.
constexpr int kParticlesPerPartial = 1024;

// Calls work(partial, branch, parameters, F, first, mine) for every register of particles and every branch in it, where
// mine[l] says whether particle first + l belongs to the branch. Returns the partial results, in the particles' order.
template <class Partial, class Work>
std::vector<Partial> over_state(const StepperSetup& setup, const State& state, Team& team, const Work& work) {
  using V = Lanes<double>;
  constexpr int W = kLanes<double>;
  const int count = static_cast<int>(state.size());
  std::vector<Partial> partial((count + kParticlesPerPartial - 1) / kParticlesPerPartial);
  team.for_each(static_cast<int>(partial.size()), [&](int share) {
    const int end = std::min(count, (share + 1) * kParticlesPerPartial);
    for (int first = share * kParticlesPerPartial; first < end; first += W) {
      Mat3<V> F = identity<V>();
      MaterialParameters<V> p{};
      bool mine[kBranchCount][W] = {}, present[kBranchCount] = {};
      for (int l = 0; l < W && first + l < end; ++l) {
        const int i = first + l, row = setup.row[i], branch = static_cast<int>(setup.branches[row]);
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) F[a][b][l] = state.F[i][a][b];
        const MaterialParameters<double> q = setup.parameters_of(i);
        p.mu[l] = q.mu, p.lambda[l] = q.lambda, p.bulk[l] = q.bulk;
        p.alpha[l] = q.alpha, p.cohesion[l] = q.cohesion, p.friction[l] = q.friction;
        mine[branch][l] = present[branch] = true;
      }
      for (int branch = 0; branch < kBranchCount; ++branch) {
        if (present[branch]) work(partial[share], static_cast<Branch>(branch), p, F, first, mine[branch]);
      }
    }
  });
  return partial;
}

}  // namespace

ElasticSummary summarise_elastic(const StepperSetup& setup, const State& state, Team& team) {
  using V = Lanes<double>;
  const auto partial =
      over_state<ElasticSummary>(setup, state, team,
                                 [&](ElasticSummary& out, Branch branch, const MaterialParameters<V>& p,
                                     const Mat3<V>& F, int first, const bool* mine) {
                                   const V energy = branch_energy(branch, p, F), J = determinant(F);
                                   for (int l = 0; l < kLanes<double>; ++l) {
                                     if (!mine[l]) continue;
                                     out.energy += setup.volume[first + l] * energy[l];
                                     if (has_potential(branch)) out.recoverable += setup.volume[first + l] * energy[l];
                                     out.min_J = std::min(out.min_J, double(J[l]));
                                     out.max_J = std::max(out.max_J, double(J[l]));
                                   }
                                 });
  ElasticSummary total;
  for (const ElasticSummary& p : partial) {
    total.energy += p.energy;
    total.recoverable += p.recoverable;
    total.min_J = std::min(total.min_J, p.min_J);
    total.max_J = std::max(total.max_J, p.max_J);
  }
  return total;
}

StepBounds measure_bounds(const StepperSetup& setup, const State& state, Team& team, bool rigid_held) {
  using V = Lanes<double>;
  struct Partial {
    double softness = std::numeric_limits<double>::infinity();  // ρ/a
    double speed = 0, gradient = 0;                             // squared
  };
  const auto partial = over_state<Partial>(
      setup, state, team,
      [&](Partial& out, Branch branch, const MaterialParameters<V>& p, const Mat3<V>& F, int first, const bool* mine) {
        const V stiffness = stiffness_bound(branch, p, F);
        for (int l = 0; l < kLanes<double>; ++l) {
          if (!mine[l]) continue;
          const int i = first + l;
          if (!rigid_held || setup.rigid.body_of(setup.row[i]) < 0)
            out.softness = std::min(out.softness, setup.parameters_of(i).density / double(stiffness[l]));
          out.speed = std::max(out.speed, dot(state.v[i], state.v[i]));
          out.gradient = std::max(out.gradient, squared_norm(state.C[i]));
        }
      });
  Partial total;
  for (const Partial& p : partial) {
    total.softness = std::min(total.softness, p.softness);
    total.speed = std::max(total.speed, p.speed);
    total.gradient = std::max(total.gradient, p.gradient);
  }
  return {setup.domain.dx() * std::sqrt(total.softness), std::sqrt(total.speed), std::sqrt(total.gradient)};
}

}  // namespace physmas::mpm
