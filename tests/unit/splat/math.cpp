#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "splat/lanes.h"
#include "splat/polar.h"
#include "splat/sh.h"
#include "unit/splat/reference.h"

using namespace physmas;

TEST_CASE("splat: spherical harmonics equal their closed forms and are orthonormal") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 200; ++round) {
    const Eigen::Vector3d d = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    double basis[16];
    splat::sh_basis<double>(3, d, basis);
    for (int k = 0; k < 16; ++k) CHECK(basis[k] == doctest::Approx(splat_test::reference_sh(k, d)).epsilon(1e-9));
  }
  // Midpoint rule over the sphere in (z, phi), where the surface element is constant.
  const int n = 200;
  const double pi = std::acos(-1.0);
  Eigen::Matrix<double, 16, 16> gram = Eigen::Matrix<double, 16, 16>::Zero();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double z = -1 + 2 * (i + 0.5) / n, phi = 2 * pi * (j + 0.5) / n, r = std::sqrt(1 - z * z);
      Eigen::Matrix<double, 16, 1> b;
      splat::sh_basis<double>(3, Eigen::Vector3d(r * std::cos(phi), r * std::sin(phi), z), b.data());
      gram += b * b.transpose() * (4 * pi / (n * n));
    }
  }
  CHECK((gram - Eigen::Matrix<double, 16, 16>::Identity()).cwiseAbs().maxCoeff() < 1e-3);
}

TEST_CASE("splat: the polar rotation is the proper rotation nearest to F") {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 2000; ++round) {
    Eigen::Matrix3d F;
    for (int k = 0; k < 9; ++k) F.data()[k] = normal(random);
    if (round % 5 == 1) F.col(0) *= 1e-6;
    if (round % 5 == 2) F *= 1e30;
    if (round % 5 == 3) F.row(1) = F.row(0);
    const Eigen::Matrix3d R = splat::polar_rotation(F);
    CHECK((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-10);
    CHECK(R.determinant() == doctest::Approx(1));
    // The nearest proper rotation maximises tr(R^T F): s1 + s2 +- s3.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F);
    const Eigen::Vector3d s = svd.singularValues();
    const double best = s[0] + s[1] + (F.determinant() < 0 ? -s[2] : s[2]);
    CHECK((R.transpose() * F).trace() == doctest::Approx(best).epsilon(1e-8));
  }
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  CHECK(splat::polar_rotation(Eigen::Matrix3d::Zero()) == identity);
  CHECK(splat::polar_rotation(identity * std::numeric_limits<double>::quiet_NaN()) == identity);
  CHECK(splat::polar_rotation(-identity).determinant() == doctest::Approx(1));
}

TEST_CASE("splat: the vector exponential is as exact as float") {
  for (float p = 0; p > -29; p -= 0.0137f) {
    splat::Lanes y = splat::Lanes{} + p;
    splat::exp2_nonpositive(&y);
    CHECK(std::abs(y[3] / std::exp2(double(p)) - 1) < 3e-7);
  }
  splat::Lanes tiny = splat::Lanes{} - 1e30f;
  splat::exp2_nonpositive(&tiny);
  const float first = tiny[0];
  CHECK(first < 1e-8f);
}
