// The deformation that carries a stress.
#include "mpm/material/carry.h"

#include <doctest/doctest.h>

#include <random>
#include <string>

#include "mpm/material/constitutive.h"

using namespace physmas::mpm;

namespace {

Symmetric<double> random_stress(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(random), uniform(random), uniform(random), uniform(random), uniform(random), uniform(random)};
}

double distance(const Symmetric<double>& a, const Symmetric<double>& b) {
  return std::sqrt(squared_norm(a + (-1.0) * b));
}

}  // namespace

TEST_CASE("mpm carry: every law gives back the stress that it bears") {
  ProfileConstants constants;
  constants.foam_yield = constants.plasticine_yield = 1e9;
  constants.sand_cohesion = constants.snow_cohesion = constants.plasticine_cohesion = 1e9;
  std::mt19937 random(7);
  for (int b = 0; b < kBranchCount; ++b) {
    const Branch branch = static_cast<Branch>(b);
    if (branch == Branch::sand) continue;  // bears no tension
    CAPTURE(std::string(branch_name(branch)));
    const Material material = {branch, 1e6, 0.3, 1000};
    const MaterialParameters<double> p = derive_parameters(material, constants);
    for (const double size : {1e-3, 1.0, 1e3, 1e5}) {
      for (int sample = 0; sample < 50; ++sample) {
        const Symmetric<double> tau = random_stress(random, size);
        const Carried carried = carry_stress(branch, p, tau);
        CHECK_FALSE(carried.limited);
        // Strains are told apart from 1 down to some 1e-15.
        const double rounding = 1e-9 * std::sqrt(squared_norm(tau)) + 1e-14 * material.E;
        CHECK(distance(carried.tau, tau) < rounding);
        CHECK(distance(from_matrix(branch_stress(branch, p, carried.F)), tau) < rounding);
        CHECK(squared_norm(carried.F - transpose(carried.F)) < 1e-28);
      }
    }
  }
}

TEST_CASE("mpm carry: up to the yield, where no return map moves F") {
  std::mt19937 random(8);
  for (const Branch branch : {Branch::sand, Branch::foam, Branch::snow, Branch::plasticine}) {
    CAPTURE(std::string(branch_name(branch)));
    const MaterialParameters<double> p = derive_parameters({branch, 1e6, 0.3, 1000}, {});
    int limited = 0;
    for (int sample = 0; sample < 200; ++sample) {
      Symmetric<double> tau = random_stress(random, sample % 2 ? 6e3 : 3e2);
      tau.xx -= 3e3, tau.yy -= 3e3, tau.zz -= 3e3;
      const Carried carried = carry_stress(branch, p, tau);
      limited += carried.limited;
      CHECK(squared_norm(carried.tau) <= squared_norm(tau) * (1 + 1e-9));
      if (!carried.limited) CHECK(distance(carried.tau, tau) < 1.1e-4 * std::sqrt(squared_norm(tau)));
      Mat3d F = carried.F;
      double strength = p.yield;
      const Mat3d stress = update_branch(branch, p, 1e-4, F, strength);
      CHECK(squared_norm(F - carried.F) < 1e-28);
      CHECK(distance(from_matrix(stress), carried.tau) < 1e-6 * std::sqrt(squared_norm(tau)));
    }
    CHECK(limited > 20);
    CHECK(limited < 200);
  }
}

TEST_CASE("mpm carry: beyond a law's end it bears what it can") {
  for (int b = 0; b < kBranchCount; ++b) {
    const Branch branch = static_cast<Branch>(b);
    CAPTURE(std::string(branch_name(branch)));
    const MaterialParameters<double> p = derive_parameters({branch, 1e4, 0.3, 1000}, {});
    for (const double size : {1e6, 1e12, 1e300, -1e6, -1e12, -1e300}) {
      for (const Symmetric<double>& tau :
           {Symmetric<double>{size, size, size, 0, 0, 0}, Symmetric<double>{size, 0, 0, 0, 0, 0},
            Symmetric<double>{0, 0, 0, size, 0, 0}}) {
        const Carried carried = carry_stress(branch, p, tau);
        CHECK(carried.limited);
        const Vec3d s = svd(carried.F).s;
        CHECK(s.x <= kLargestCarriedStretch * (1 + 1e-9));
        CHECK(s.z >= 1 / kLargestCarriedStretch * (1 - 1e-9));
      }
    }
  }
}
