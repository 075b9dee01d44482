#include <algorithm>

#include "mpm/cpu/state_lanes.h"
#include "mpm/material/constitutive.h"

namespace physmas::mpm {

ElasticSummary summarise_elastic(const StepperSetup& setup, const State& state) {
  using V = Lanes<double>;
  const auto partial =
      over_state<ElasticSummary>(setup, state,
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

}  // namespace physmas::mpm
