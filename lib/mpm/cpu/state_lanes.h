// Evaluates a function of material and deformation over all particles of a state, in double precision.
#ifndef PHYSMAS_MPM_CPU_STATE_LANES_H
#define PHYSMAS_MPM_CPU_STATE_LANES_H

#include <algorithm>
#include <vector>

#include "mpm/stepper.h"

namespace physmas::mpm {

// Particles per partial result: fixed, so that what is summed does not depend on the threads.
constexpr int kParticlesPerPartial = 1024;

// Calls work(partial, branch, parameters, F, first, mine) for every register of particles and every branch in it, where
// mine[l] says whether particle first + l belongs to the branch. Returns the partial results, in the particles' order.
template <class Partial, class Work>
std::vector<Partial> over_state(const StepperSetup& setup, const State& state, const Work& work) {
  using V = Lanes<double>;
  constexpr int W = kLanes<double>;
  const int count = static_cast<int>(state.size());
  std::vector<Partial> partial((count + kParticlesPerPartial - 1) / kParticlesPerPartial);
  setup.team->for_each(static_cast<int>(partial.size()), [&](int share) {
    const int end = std::min(count, (share + 1) * kParticlesPerPartial);
    for (int first = share * kParticlesPerPartial; first < end; first += W) {
      Mat3<V> F = identity<V>();
      MaterialParameters<V> p{};
      bool mine[kBranchCount][W] = {}, present[kBranchCount] = {};
      for (int l = 0; l < W && first + l < end; ++l) {
        const int i = first + l, row = setup.row[i], branch = static_cast<int>(setup.branches[row]);
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) F[a][b][l] = state.F[i][a][b];
        const MaterialParameters<double>& q = setup.parameters[row];
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

}  // namespace physmas::mpm

#endif
