#include "mpm/material/carry.h"

#include <algorithm>
#include <cmath>

#include "mpm/material/constitutive.h"

namespace physmas::mpm {

namespace {

// Zero of a function that falls from low to high, by regula falsi with the Illinois rule; an end where it has none.
template <class Function>
double falling_zero(double low, double high, const Function& value) {
  double at_low = value(low), at_high = value(high);
  if (!(at_low > 0)) return low;
  if (!(at_high < 0)) return high;
  double middle = low;
  for (int step = 0, side = 0; step < 100; ++step) {
    const double before = middle;
    middle = low + (high - low) * (at_low / (at_low - at_high));
    if (std::fabs(middle - before) <= 2 * kEpsilon<double> * std::fabs(middle)) break;
    const double here = value(middle);
    if (here > 0) {
      low = middle, at_low = here;
      if (side == 1) at_high *= 0.5;
      side = 1;
    } else if (here < 0) {
      high = middle, at_high = here;
      if (side == -1) at_low *= 0.5;
      side = -1;
    } else {
      break;
    }
  }
  return middle;
}

constexpr double kLow = 1 / kLargestCarriedStretch, kHigh = kLargestCarriedStretch;
constexpr double kLowJ = kLow * kLow * kLow, kHighJ = kHigh * kHigh * kHigh;

// τ = μ J^(−2/3) dev b + κ/2 (J² − 1) I: the mean gives J, the deviator b but for its mean m, and Π b_i = J² that.
Vec3d jelly_stretches(const Vec3d& tau, const MaterialParameters<double>& p) {
  const double mean = sum(tau) / 3;
  const double J = std::min(std::max(std::sqrt(std::max(0.0, 1 + 2 * mean / p.bulk)), kLowJ), kHighJ);
  const Vec3d d = (std::cbrt(J * J) / p.mu) * deviator(tau);
  const double lowest = -std::min({d.x, d.y, d.z});
  const double m = falling_zero(lowest, lowest + 2 * kHigh * kHigh,
                                [&](double m) { return J * J - (m + d.x) * (m + d.y) * (m + d.z); });
  Vec3d s;
  for (int i = 0; i < 3; ++i) s[i] = std::sqrt(std::max(0.0, m + d[i]));
  return s;
}

// τ_i = 2 μ (s_i − 1) s_i + λ (J − 1) J: given J, each s_i is the larger root of a quadratic, and Π s_i = J.
Vec3d metal_stretches(const Vec3d& tau, const MaterialParameters<double>& p) {
  const auto given = [&](double J) {
    Vec3d s;
    for (int i = 0; i < 3; ++i) {
      const double rest = (tau[i] - p.lambda * (J - 1) * J) / p.mu;
      s[i] = 0.5 * (1 + std::sqrt(std::max(0.0, 1 + 2 * rest)));
    }
    return s;
  };
  // Below J = 1/2 less volume means less pressure: there is nothing to find.
  return given(falling_zero(0.5, kHighJ, [&](double J) {
    const Vec3d s = given(J);
    return s.x * s.y * s.z - J;
  }));
}

// The part of a stress that no return map and no cone takes away.
Vec3d below_yield(Branch branch, const Vec3d& tau, const MaterialParameters<double>& p) {
  const double mean = sum(tau) / 3, size = norm(deviator(tau));
  double cut = mean, limit = std::numeric_limits<double>::infinity();
  if (branch == Branch::foam || branch == Branch::plasticine) limit = kRootTwoThirds * p.yield;
  if (has_stress_cone(branch)) {
    cut = std::min(mean, p.apex);
    limit = std::min(limit, p.cohesion - 3 * p.alpha * cut);
  }
  if (branch == Branch::sand) {
    cut = std::min(cut, 0.0);
    limit = std::min(limit, -3 * p.friction * cut);
  }
  // A little inside: numbers of single precision must not find themselves beyond.
  limit = std::max(0.0, (1 - 1e-6) * limit);
  return apply<double>({cut, size > limit ? limit / size : 1, 0}, tau);
}

Vec3d hencky_stretches(Branch branch, const Vec3d& tau, const MaterialParameters<double>& p) {
  const Vec3d borne = below_yield(branch, tau, p), d = deviator(borne);
  const double mean = sum(borne) / (9 * p.bulk);
  Vec3d s;
  for (int i = 0; i < 3; ++i) s[i] = std::exp(mean + d[i] * p.inverse_mu);
  return s;
}

}  // namespace

Carried carry_stress(Branch branch, const MaterialParameters<double>& p, const Symmetric<double>& tau) {
  const Mat3d T = to_matrix(tau);
  // Principal directions by singular values, of a matrix without negative ones.
  const double shift = 2 * std::sqrt(squared_norm(tau));
  if (!(shift > 0)) return {identity<double>(), tau, false};
  if (!std::isfinite(shift)) return {identity<double>(), {0, 0, 0, 0, 0, 0}, true};
  const Mat3d U = svd(T + shift * identity<double>()).U;
  Vec3d principal;
  for (int i = 0; i < 3; ++i) {
    const Vec3d direction = {U[0][i], U[1][i], U[2][i]};
    principal[i] = dot(direction, T * direction);
  }
  Vec3d s = branch == Branch::jelly   ? jelly_stretches(principal, p)
            : branch == Branch::metal ? metal_stretches(principal, p)
                                      : hencky_stretches(branch, principal, p);
  for (int i = 0; i < 3; ++i) s[i] = std::min(std::max(s[i], kLow), kHigh);
  Carried carried;
  carried.F = from_principal(U, s);
  carried.tau = from_matrix(branch_stress(branch, p, carried.F));
  const Symmetric<double> missing = tau + (-1.0) * carried.tau;
  carried.limited = std::sqrt(squared_norm(missing)) > 1e-4 * std::sqrt(squared_norm(tau));
  return carried;
}

}  // namespace physmas::mpm
