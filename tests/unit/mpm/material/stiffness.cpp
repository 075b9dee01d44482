// How stiff a deformed particle is at most: against finite differences of its stress.
#include "mpm/material/stiffness.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

using namespace physmas::mpm;

namespace {

constexpr Branch kBranches[] = {Branch::jelly, Branch::metal, Branch::sand,
                                Branch::foam,  Branch::snow,  Branch::plasticine};

MaterialParameters<double> parameters(Branch branch, double nu = 0.3) {
  return derive_parameters({branch, 1e5, nu, 1000}, {});
}

Mat3d stress(Branch branch, const MaterialParameters<double>& p, Mat3d F) {
  double strength = 1e30;  // never yields by von Mises
  return update_branch(branch, p, 0.0, F, strength);
}

// Largest |rate of stress| / |velocity gradient| over random gradients, by finite differences.
double measured_stiffness(Branch branch, const MaterialParameters<double>& p, const Mat3d& F) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double most = 0;
  for (int k = 0; k < 60; ++k) {
    Mat3d G = diagonal(0.0, 0.0, 0.0);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) G[i][j] = normal(random);
    if (k == 0) G = identity<double>();  // a change of volume: the stiffest direction at rest
    G = (1 / std::sqrt(squared_norm(G))) * G;
    const double h = 1e-6;
    const Mat3d change = stress(branch, p, F + h * (G * F)) - stress(branch, p, F - h * (G * F));
    most = std::max(most, std::sqrt(squared_norm(change)) / (2 * h));
  }
  return most;
}

}  // namespace

TEST_CASE("mpm stiffness: at rest it is 3 kappa or 2 mu, whichever is larger") {
  for (const Branch branch : kBranches) {
    for (const double nu : {0.0, 0.2, 0.45, 0.499}) {
      const auto p = parameters(branch, nu);
      const double rest = std::max(3 * p.bulk, 2 * p.mu);
      CHECK(rest_stiffness(p) == rest);
      const double bound = stiffness_bound(branch, p, identity<double>());
      CHECK(bound >= rest);
      // The coupling of sand's cone is the largest surcharge, sqrt(1 + 3 · 0.3266²) = 1.149; shear is rounded up by 1
      // %.
      CHECK(bound <= 1.17 * rest);
    }
  }
}

TEST_CASE("mpm stiffness: principal stretches are the singular values, in order, with the sign of an inversion") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> entry(-1, 1);
  double worst = 0;
  int inverted = 0;
  for (int k = 0; k < 20000; ++k) {
    // From nearly the identity, where all are alike, to anything.
    const double size = std::pow(10.0, -k % 12);
    Mat3d F = identity<double>();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F[i][j] += 2 * size * entry(random);
    const Vec3d s = svd(F).s, mine = principal_stretches(F);
    inverted += s.z < 0;
    for (int i = 0; i < 3; ++i) worst = std::max(worst, std::fabs(mine[i] - s[i]) / s.x);
    CHECK(mine.x * mine.y * mine.z == doctest::Approx(determinant(F)));
  }
  CHECK(inverted > 100);
  // Roots of eigenvalues that are alike lose half of the digits.
  CHECK(worst < 2e-8);
}

TEST_CASE("mpm stiffness: the bound is never below what finite differences of the stress measure") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> stretch(std::log(0.1), std::log(3.0)), entry(-0.4, 0.4);
  for (const Branch branch : kBranches) {
    const auto p = parameters(branch);
    double tightest = 1e30;
    for (int k = 0; k < 60; ++k) {
      Mat3d F = diagonal(std::exp(stretch(random)), std::exp(stretch(random)), std::exp(stretch(random)));
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) F[i][j] += entry(random) * F[j][j];
      if (determinant(F) < 0.01) continue;
      const double measured = measured_stiffness(branch, p, F);
      const double bound = stiffness_bound(branch, p, F);
      INFO(std::string(branch_name(branch)), " F = ", F[0].x, " ", F[1].y, " ", F[2].z, " J = ", determinant(F));
      CHECK(measured <= bound * (1 + 1e-5));  // finite differences
      tightest = std::min(tightest, bound / std::max(measured, 1.0));
    }
    CHECK(tightest < 3);  // a bound that is always far off would only cost time
  }
}

TEST_CASE("mpm stiffness: finite and at least that of rest for every finite F") {
  for (const Branch branch : kBranches) {
    const auto p = parameters(branch);
    for (const Mat3d& F : {diagonal(0.0, 0.0, 0.0), diagonal(1.0, 1.0, -1.0), diagonal(-1.0, -1.0, -1.0),
                           diagonal(1e30, 1.0, 1e-30), diagonal(1.0, 0.0, 0.0), diagonal(1e-3, 1e-3, -1e-3)}) {
      const double a = stiffness_bound(branch, p, F);
      CHECK(std::isfinite(a));
      CHECK(a >= rest_stiffness(p));
    }
  }
}
