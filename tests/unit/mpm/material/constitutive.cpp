// The six branches on single deformation gradients: energies, yield surfaces, extreme input.
#include "mpm/material/constitutive.h"

#include <doctest/doctest.h>

#include <random>
#include <vector>

using namespace physmas;
using namespace physmas::mpm;

namespace {

MaterialParameters<double> parameters(Branch branch, double E = 1e5, double nu = 0.3) {
  return derive_parameters({branch, E, nu, 1000}, {});
}

Mat3d random_matrix(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Mat3d a;
  for (int i = 0; i < 3; ++i) a[i] = {uniform(random), uniform(random), uniform(random)};
  return a;
}

double distance(const Mat3d& a, const Mat3d& b) {
  return std::sqrt(squared_norm(a - b));
}

Mat3d deviatoric(const Mat3d& a) {
  return a - (trace(a) / 3) * identity<double>();
}

// Kirchhoff stress P Fᵀ with P the central difference of the energy.
Mat3d numerical_stress(Branch branch, const MaterialParameters<double>& p, const Mat3d& F) {
  const double h = 1e-6;
  Mat3d P;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      Mat3d up = F, down = F;
      up[i][j] += h;
      down[i][j] -= h;
      P[i][j] = (branch_energy(branch, p, up) - branch_energy(branch, p, down)) / (2 * h);
    }
  }
  return times_transposed(P, F);
}

Mat3d elastic_stress(Branch branch, const MaterialParameters<double>& p, const Mat3d& F) {
  if (branch == Branch::jelly) return jelly_stress(F, p.mu, p.bulk);
  if (branch == Branch::metal) return metal_stress(F, p.mu, p.lambda);
  return hencky_stress(F, p.mu, p.lambda);
}

const Branch kElastic[] = {Branch::jelly, Branch::metal, Branch::foam};
const Branch kAll[] = {Branch::jelly, Branch::metal, Branch::sand, Branch::foam, Branch::snow, Branch::plasticine};

}  // namespace

TEST_CASE("mpm constitutive: stress is the gradient of the energy") {
  std::mt19937 random(5);
  for (const Branch branch : kElastic) {
    const auto p = parameters(branch);
    double worst = 0;
    for (int k = 0; k < 300; ++k) {
      const Mat3d F = identity<double>() + random_matrix(random, 0.3);
      if (determinant(F) < 0.1) continue;
      const Mat3d tau = elastic_stress(branch, p, F);
      worst = std::max(worst, distance(tau, numerical_stress(branch, p, F)) / (p.lambda + 2 * p.mu));
    }
    INFO(branch_name(branch));
    // Central differences with h = 1e-6: truncation 1e-12 times third derivatives, cancellation 1e-16 / 1e-6.
    CHECK(worst < 1e-7);
  }
}

TEST_CASE("mpm constitutive: jelly and metal keep their potential under inversion and collapse") {
  for (const Branch branch : {Branch::jelly, Branch::metal}) {
    const auto p = parameters(branch);
    for (const Mat3d& F : {diagonal(1.1, 0.9, -0.4), diagonal(0.9, 0.8, 0.01), diagonal(0.5, 0.3, 0.2),
                           Mat3d{{{1, 0.2, 0.1}, {0, -0.7, 0.3}, {0.1, 0, 1.2}}}}) {
      const Mat3d tau = elastic_stress(branch, p, F);
      INFO(branch_name(branch));
      // Jelly is stiff next to the floor (energies of 100 moduli), so the difference quotient has fewer digits.
      CHECK(distance(tau, numerical_stress(branch, p, F)) / (p.lambda + 2 * p.mu) < 1e-5);
    }
  }
}

TEST_CASE("mpm constitutive: Sand, Snow and Plasticine follow the gradient of their energy where nothing yields") {
  std::mt19937 random(31);
  for (const Branch branch : {Branch::sand, Branch::snow, Branch::plasticine}) {
    const auto p = parameters(branch);
    for (int k = 0; k < 100; ++k) {
      // Pressed, and hardly sheared: inside the cones of all three, and below plasticine's strength.
      const Mat3d F = 0.98 * (identity<double>() + random_matrix(random, 1e-3));
      Mat3d after = F;
      double strength = p.yield;
      const Mat3d tau = update_branch(branch, p, 1e-4, after, strength);
      INFO(branch_name(branch));
      CHECK(distance(after, F) == 0);
      CHECK(distance(tau, numerical_stress(branch, p, F)) / (p.lambda + 2 * p.mu) < 1e-7);
    }
  }
}

TEST_CASE("mpm constitutive: below the floor of stretches the Hencky stress along that axis is still the gradient") {
  // Across it, the stress leaves out the coupling lambda (s / floor - 1) of the continued energy (docs/numerics.md).
  const auto p = parameters(Branch::foam);
  for (const double s : {0.04, 0.01, -0.02, -0.4}) {
    const Mat3d F = diagonal(1.1, 0.9, s);
    const Mat3d tau = elastic_stress(Branch::foam, p, F), gradient = numerical_stress(Branch::foam, p, F);
    const double coupling = p.lambda * (s / kStretchFloor - 1);
    // Differences of energies of ten moduli.
    CHECK(std::fabs(tau[2].z - gradient[2].z) < 1e-6 * p.mu);
    CHECK(std::fabs(tau[0].x + coupling - gradient[0].x) < 1e-6 * p.mu);
    CHECK(std::fabs(tau[1].y + coupling - gradient[1].y) < 1e-6 * p.mu);
  }
}

TEST_CASE("mpm constitutive: an inverted element is pulled back through zero") {
  for (const Branch branch : kElastic) {
    const auto p = parameters(branch);
    // Principal first Piola stress along the inverted axis: tau / s must be negative, that is, push s upwards.
    const Mat3d tau = elastic_stress(branch, p, diagonal(1.0, 1.0, -0.3));
    CHECK(tau[2].z / -0.3 < 0);
  }
}

TEST_CASE("mpm constitutive: small strains follow Hooke's law with the given E and nu") {
  for (const Branch branch : kElastic) {
    const double E = 1e5, nu = 0.2, e = 1e-6;
    const auto p = parameters(branch, E, nu);
    // Uniaxial stress: lateral strain −nu e, axial stress E e. Second-order terms are e² of the modulus.
    const Mat3d tau = elastic_stress(branch, p, diagonal(1 - nu * e, 1 - nu * e, 1 + e));
    CHECK(tau[2].z == doctest::Approx(E * e).epsilon(1e-4));
    CHECK(std::fabs(tau[0].x) < 1e-4 * E * e);
  }
}

TEST_CASE("mpm constitutive: stress turns with the material and ignores rotations of the rest state") {
  std::mt19937 random(9);
  for (const Branch branch : kAll) {
    const auto p = parameters(branch);
    for (int k = 0; k < 100; ++k) {
      const Mat3d F = identity<double>() + random_matrix(random, 0.3);
      const Mat3d R = polar_rotation(random_matrix(random, 1)), S = polar_rotation(random_matrix(random, 1));
      Mat3d plain = F, turned = R * (F * S);
      double strength = p.yield, turned_strength = p.yield;
      const Mat3d tau = update_branch(branch, p, 1e-4, plain, strength);
      const Mat3d turned_tau = update_branch(branch, p, 1e-4, turned, turned_strength);
      INFO(branch_name(branch));
      // Rounding of the decomposition, on stresses of the order of the modulus.
      CHECK(distance(turned_tau, R * (tau * transpose(R))) < 1e-10 * (p.lambda + 2 * p.mu));
      CHECK(distance(turned, R * (plain * S)) < 1e-11);
      CHECK(std::fabs(turned_strength - strength) < 1e-8 * p.yield);
    }
  }
}

TEST_CASE("mpm constitutive: stress of Sand, Snow and Plasticine lies on or inside its cone") {
  std::mt19937 random(13);
  for (const Branch branch : {Branch::sand, Branch::snow, Branch::plasticine}) {
    const auto p = parameters(branch);
    for (int k = 0; k < 2000; ++k) {
      Mat3d F = identity<double>() + random_matrix(random, k % 2 ? 0.4 : 0.01);
      double strength = p.yield;
      const Mat3d tau = update_branch(branch, p, 1e-4, F, strength);
      const double size = std::sqrt(squared_norm(deviatoric(tau)));
      const double rounding = 1e-10 * (p.lambda + 2 * p.mu);
      INFO(branch_name(branch));
      CHECK(size <= std::max(0.0, p.cohesion - p.alpha * trace(tau)) + rounding);
      CHECK(trace(tau) <= p.cohesion / p.alpha + rounding);
    }
  }
}

TEST_CASE("mpm constitutive: return maps land on or inside the yield surface, are idempotent and dissipate") {
  std::mt19937 random(17);
  for (const Branch branch : {Branch::sand, Branch::foam, Branch::plasticine}) {
    ProfileConstants constants;
    constants.foam_viscosity = 0;        // the rate-independent limit, where the surface is reached at once
    constants.plasticine_softening = 0;  // else a second application finds a lower strength
    const auto p = derive_parameters({branch, 1e5, 0.3, 1000}, constants);
    for (int k = 0; k < 1000; ++k) {
      const Mat3d trial = identity<double>() + random_matrix(random, k % 2 ? 0.3 : 0.02);
      if (determinant(trial) < 0.05) continue;
      Mat3d F = trial;
      double strength = p.yield;
      update_branch(branch, p, 1e-4, F, strength);
      const double stiffness = p.lambda + 2 * p.mu;
      const Mat3d tau = hencky_stress(F, p.mu, p.lambda);
      const double size = std::sqrt(squared_norm(deviatoric(tau)));
      const double limit =
          branch == Branch::sand ? std::max(0.0, -p.friction * trace(tau)) : std::sqrt(2.0 / 3.0) * strength;
      INFO(branch_name(branch));
      CHECK(size <= limit + 1e-10 * stiffness);
      CHECK(hencky_energy(F, p.mu, p.lambda) <= hencky_energy(trial, p.mu, p.lambda) * (1 + 1e-10) + 1e-10);
      Mat3d again = F;
      update_branch(branch, p, 1e-4, again, strength);
      CHECK(distance(again, F) < 1e-11);
    }
  }
}

TEST_CASE("mpm constitutive: foam relaxes at the rate that its viscosity sets") {
  const auto p = parameters(Branch::foam);
  const Mat3d trial = diagonal(1.2, 1.0, 1 / 1.2);
  const auto excess = [&](const Mat3d& F) {
    return std::sqrt(squared_norm(deviatoric(hencky_stress(F, p.mu, p.lambda)))) - std::sqrt(2.0 / 3.0) * p.yield;
  };
  const double dt = 1e-5;
  Mat3d F = trial;
  double strength = p.yield;
  update_branch(Branch::foam, p, dt, F, strength);
  // Yue et al. 2015: the excess shrinks by 1 / (1 + 2 mu_hat dt / viscosity), mu_hat = mu tr b / 3.
  const double mu_hat = p.mu * squared_norm(trial) / 3;
  CHECK(excess(F) == doctest::Approx(excess(trial) / (1 + 2 * mu_hat * dt / p.viscosity)).epsilon(1e-9));
  CHECK(determinant(F) == doctest::Approx(determinant(trial)).epsilon(1e-12));  // flow keeps the volume
}

TEST_CASE("mpm constitutive: damage lowers plasticine's strength to the residual and keeps its bulk stiffness") {
  ProfileConstants constants;
  constants.plasticine_softening = 1e4;
  const auto p = derive_parameters({Branch::plasticine, 1e5, 0.3, 1000}, constants);
  double strength = p.yield;
  Mat3d F = diagonal(1.02, 1.0, 1 / 1.02);
  update_branch(Branch::plasticine, p, 1e-4, F, strength);
  // The strength falls by softening times the plastic part of the strain.
  const double plastic = std::sqrt(2.0) * std::log(1.02) - std::sqrt(2.0 / 3.0) * p.yield / (2 * p.mu);
  CHECK(strength == doctest::Approx(p.yield - 1e4 * plastic).epsilon(1e-9));
  for (int k = 0; k < 100; ++k) {
    F = diagonal(1.2, 1.0, 1 / 1.2) * F;
    update_branch(Branch::plasticine, p, 1e-4, F, strength);
  }
  CHECK(strength == doctest::Approx(p.residual_yield).epsilon(1e-12));
  Mat3d pressed = diagonal(0.98, 0.98, 0.98);
  const Mat3d tau = update_branch(Branch::plasticine, p, 1e-4, pressed, strength);
  CHECK(trace(tau) / 3 == doctest::Approx(3 * p.bulk * std::log(0.98)).epsilon(1e-9));
}

TEST_CASE("mpm constitutive: no branch returns a number that is not finite, in float and in double") {
  std::mt19937 random(23);
  std::vector<Mat3d> extremes = {diagonal(0.0, 0.0, 0.0),      diagonal(1.0, 1.0, -1.0),
                                 diagonal(-1.0, -1.0, -1.0),   diagonal(1e-30, 1e-30, 1e-30),
                                 diagonal(1e30, 1e30, 1e30),   diagonal(1e30, 1.0, 0.0),
                                 diagonal(3e38, -3e38, 1e-38), diagonal(1e-10, 1.0, 1e10),
                                 diagonal(0.0, 0.0, 2.0),      {{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}};
  for (int k = 0; k < 2000; ++k) extremes.push_back(std::pow(10.0, k % 60 - 30) * random_matrix(random, 1));
  const auto check = [&](auto zero) {
    using T = decltype(zero);
    for (const Branch branch : kAll) {
      const auto p = convert_parameters<T>(derive_parameters({branch, 3e11, 0.499, 7800}, {}));
      for (const Mat3d& exact : extremes) {
        Mat3<T> F;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) F[i][j] = T(exact[i][j]);
        T strength = p.yield;
        const T energy = branch_energy(branch, p, F);
        const Mat3<T> tau = update_branch(branch, p, T(2e-4), F, strength);
        bool finite = std::isfinite(energy) && std::isfinite(strength);
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) finite = finite && std::isfinite(tau[i][j]) && std::isfinite(F[i][j]);
        INFO(branch_name(branch), " ", exact[0].x, " ", exact[1].y, " ", exact[2].z);
        CHECK(finite);
      }
    }
  };
  check(0.0f);
  check(0.0);
}

TEST_CASE("mpm constitutive: a return map leaves what does not yield bit for bit as it is") {
  std::mt19937 random(29);
  for (const Branch branch : {Branch::foam, Branch::plasticine}) {
    const auto p = parameters(branch);
    const Mat3d F = identity<double>() + random_matrix(random, 1e-3);
    Mat3d after = F;
    double strength = p.yield;
    update_branch(branch, p, 1e-4, after, strength);
    CHECK(distance(after, F) == 0);
    CHECK(strength == p.yield);
  }
}

TEST_CASE(
    "mpm constitutive: polynomials agree with the decompositions, for nearly equal and very different stretches") {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto check = [&](auto zero) {
    using T = decltype(zero);
    using V = Lanes<T>;
    double worst_stress = 0, worst_F = 0;
    int yielding = 0, outside = 0, far_outside = 0;
    for (const Branch branch : kAll) {
      if (branch == Branch::jelly) continue;
      for (int k = 0; k < 3000; ++k) {
        // Stretches of all kinds: far apart, two or three alike to any number of digits, none at all.
        const double spread = std::pow(10.0, -k % 9), pair = std::pow(10.0, -k % 7);
        // Some beyond the polynomials of F Fᵀ, where the left stretch takes over.
        const double width = k % 5 ? 0.5 : 0.9;
        const double base = 1 + 0.1 * uniform(random), a = base * (1 + width * spread * uniform(random));
        const double b = k % 3 ? a * (1 + 0.5 * pair * uniform(random)) : a;
        const Mat3d stretch = diagonal(base, a, b);
        outside += !in_range(deviation(left_cauchy_green(stretch)));
        far_outside += !in_range(deviation(from_matrix(stretch)));
        const Mat3d U = polar_rotation(random_matrix(random, 1)), W = polar_rotation(random_matrix(random, 1));
        const Mat3d exact = U * (stretch * W);
        const auto p = convert_parameters<V>(parameters(branch));
        Mat3<V> F, other_F;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) F[i][j] = V(T(exact[i][j]));
        other_F = F;
        V strength = p.yield, other_strength = p.yield;
        const V dt(T(1e-4));
        const Mat3<V> tau = update_branch(branch, p, dt, F, strength);
        const Mat3<V> other = branch == Branch::metal ? metal_stress_by_rotation(other_F, p.mu, p.lambda)
                                                      : update_hencky_by_svd(branch, p, dt, other_F, other_strength);
        const T stiffness = p.lambda[0] + 2 * p.mu[0];
        worst_stress = std::max(worst_stress, std::sqrt(double(squared_norm(tau - other)[0])) / stiffness);
        worst_F = std::max(worst_F, std::sqrt(double(squared_norm(F - other_F)[0])));
        yielding += other_strength[0] < p.yield[0];
        CHECK(std::fabs(strength[0] - other_strength[0]) < T(64) * kEpsilon<T> * stiffness);
      }
    }
    CHECK(outside > 300);
    CHECK(far_outside > 30);
    // Rounding of F Fᵀ, of order one, and of what follows; twenty operations deep.
    CHECK(worst_stress < 32 * kEpsilon<T>);
    CHECK(worst_F < 32 * kEpsilon<T>);
    CHECK(yielding > 300);
    MESSAGE("stress within ", worst_stress / kEpsilon<T>, " roundings of the modulus, F within ",
            worst_F / kEpsilon<T>);
  };
  check(0.0f);
  check(0.0);
}
