#include <algorithm>

#include "mpm/constitutive.h"
#include "mpm/stepper.h"

namespace physmas::mpm {

ElasticSummary summarise_elastic(const StepperSetup& setup, const State& state) {
  using V = Lanes<double>;
  constexpr int W = kLanes<double>;
  constexpr int kChunk = 1024;  // particles per partial sum: fixed, so the total does not depend on the threads
  const int count = static_cast<int>(state.size());
  const int chunks = (count + kChunk - 1) / kChunk;
  std::vector<ElasticSummary> partial(chunks);
  setup.team->for_each(chunks, [&](int chunk) {
    const int end = std::min(count, (chunk + 1) * kChunk);
    ElasticSummary& out = partial[chunk];
    for (int first = chunk * kChunk; first < end; first += W) {
      Mat3<V> F = identity<V>();
      MaterialParameters<V> p{};
      bool present[kBranchCount] = {};
      for (int l = 0; l < W && first + l < end; ++l) {
        const int i = first + l;
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) F[a][b][l] = state.F[i][a][b];
        p.mu[l] = setup.parameters[setup.row[i]].mu;
        p.lambda[l] = setup.parameters[setup.row[i]].lambda;
        p.bulk[l] = setup.parameters[setup.row[i]].bulk;
        present[static_cast<int>(setup.branches[setup.row[i]])] = true;
      }
      const V J = determinant(F);
      for (int branch = 0; branch < kBranchCount; ++branch) {
        if (!present[branch]) continue;
        const V energy = branch_energy(static_cast<Branch>(branch), p, F);
        for (int l = 0; l < W && first + l < end; ++l) {
          const int row = setup.row[first + l];
          if (static_cast<int>(setup.branches[row]) != branch) continue;
          out.energy += setup.volume[first + l] * energy[l];
          if (has_potential(static_cast<Branch>(branch))) out.recoverable += setup.volume[first + l] * energy[l];
          out.min_J = std::min(out.min_J, double(J[l]));
          out.max_J = std::max(out.max_J, double(J[l]));
        }
      }
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
