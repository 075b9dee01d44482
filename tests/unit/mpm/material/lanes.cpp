// The laws on SIMD lanes of many particles at once against plain numbers, one after the other.
#include "mpm/math/lanes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

#include "cuda/laws.h"

using namespace physmas::mpm;

namespace {

// Lanes of small and large strains and inversions side by side, so that rare paths are taken for some of them only.
template <class T>
void compare(Branch branch, std::mt19937& random, double& worst, double& worst_stiffness) {
  using V = Lanes<T>;
  constexpr int W = kLanes<T>;
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto p = convert_parameters<T>(derive_parameters({branch, 1e5, 0.3, 1000}, {}));
  Mat3<T> F[W];
  Mat3<V> lanes;
  for (int l = 0; l < W; ++l) {
    const double size = l % 3 == 0 ? 0.01 : l % 3 == 1 ? 0.2 : 0.7;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) lanes[i][j][l] = F[l][i][j] = T((i == j) + size * uniform(random));
    }
  }
  V together[laws::kNumbers];
  laws::evaluate(branch, convert_parameters<V>(p), V(T(1e-4)), lanes, together);
  for (int l = 0; l < W; ++l) {
    T alone[laws::kNumbers];
    laws::evaluate(branch, p, T(1e-4), F[l], alone);
    for (int k = 0; k < laws::kNumbers; ++k) {
      const double a = alone[k], b = T(together[k][l]);
      const double roundings = std::fabs(a - b) / (1 + std::fabs(a)) / kEpsilon<T>;
      double& most = k == laws::kStiffness ? worst_stiffness : worst;
      if (!(roundings <= most)) most = roundings;  // a number that is not finite counts
    }
  }
}

}  // namespace

TEST_CASE("mpm laws: lanes give what plain numbers give, for every branch and precision") {
  const auto check = [](auto zero) {
    using T = decltype(zero);
    for (int b = 0; b < kBranchCount; ++b) {
      std::mt19937 random(11 + b);
      double worst = 0, worst_stiffness = 0;
      for (int k = 0; k < 400; ++k) compare<T>(static_cast<Branch>(b), random, worst, worst_stiffness);
      INFO(std::string(kBranchNames[b]), ", ", 8 * sizeof(T), " bits: ", worst, " and ", worst_stiffness);
      CHECK(worst <= laws::kRoundings);
      CHECK(worst_stiffness <= laws::kRoundingsOfStiffness);
    }
  };
  check(0.0f);
  check(0.0);
}
