// Singular values and polar rotations against Eigen, and the lane-wise logarithm and exponential.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "mpm/svd.h"

using namespace physmas::mpm;

namespace {

Mat3d product(const Mat3d& U, const Vec3d& s, const Mat3d& Vt) {
  return U * (diagonal(s.x, s.y, s.z) * Vt);
}

Mat3d rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  q.normalize();
  const Eigen::Matrix3d R = q.toRotationMatrix();
  Mat3d r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r[i][j] = R(i, j);
  return r;
}

// Random, repeated, near-singular, rank-deficient, inverted, tiny and huge matrices, and hand-picked corners.
std::vector<Mat3d> matrices(int count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Mat3d> all;
  const double rungs[] = {0, 1e-12, 1e-7, 1e-3, 0.5, 1, 1 + 1e-7, 2, 1e4, -1e-7, -0.5, -1};
  std::uniform_int_distribution<int> pick(0, 11);
  for (int i = 0; i < count; ++i) {
    if (i % 2 == 0) {
      Mat3d a;
      for (int r = 0; r < 3; ++r) a[r] = {uniform(random), uniform(random), uniform(random)};
      all.push_back(std::pow(10.0, (i / 2) % 13 - 6) * a);
    } else {
      const Vec3d s = {rungs[pick(random)], rungs[pick(random)], rungs[pick(random)]};
      all.push_back(product(rotation(random), s, rotation(random)));
    }
  }
  all.push_back(diagonal(0.0, 0.0, 0.0));
  all.push_back(identity<double>());
  all.push_back(diagonal(-1.0, -1.0, -1.0));
  all.push_back(diagonal(1.0, -1.0, 1.0));
  all.push_back(diagonal(0.0, 0.0, 3.0));
  all.push_back({{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}});
  all.push_back({{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}}});
  return all;
}

template <class T, class From>
Mat3<T> cast(const Mat3<From>& a) {
  Mat3<T> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r[i][j] = T(a[i][j]);
  return r;
}

// Largest errors over all matrices, in units of the type's rounding and the size of the matrix.
template <class T>
void check_svd() {
  double reconstruction = 0, orthogonality = 0, values = 0, handedness = 0;
  for (const Mat3d& exact : matrices(20000)) {
    const Mat3<T> F = cast<T>(exact);
    const Svd<T> d = svd(F);
    Eigen::Matrix3d reference;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) reference(i, j) = F[i][j];
    const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3d>(reference).singularValues();
    const double unit = double(kEpsilon<T>) * std::max(s[0], 1e-300);
    const Mat3d identity3 = identity<double>();
    const Mat3d f = cast<double>(F), u = cast<double>(d.U), vt = cast<double>(d.Vt);
    const Vec3d sigma = {d.s.x, d.s.y, d.s.z};
    reconstruction = std::max(reconstruction, std::sqrt(squared_norm(product(u, sigma, vt) - f)) / unit);
    orthogonality = std::max({orthogonality, std::sqrt(squared_norm(times_transposed(u, u) - identity3)),
                              std::sqrt(squared_norm(times_transposed(vt, vt) - identity3))});
    handedness = std::max({handedness, std::fabs(determinant(u) - 1), std::fabs(determinant(vt) - 1)});
    for (int i = 0; i < 3; ++i) values = std::max(values, std::fabs(std::fabs(sigma[i]) - s[i]) / unit);
    CHECK(sigma.y >= std::fabs(sigma.z) * (1 - 16 * double(kEpsilon<T>)));
  }
  // A dozen rotations of a few roundings each; measured about 10.
  CHECK(reconstruction < 32);
  CHECK(values < 32);
  CHECK(orthogonality < 32 * double(kEpsilon<T>));
  CHECK(handedness < 32 * double(kEpsilon<T>));
}

}  // namespace

TEST_CASE("mpm svd: reconstruction, singular values and proper rotations agree with Eigen in float and double") {
  check_svd<float>();
  check_svd<double>();
}

TEST_CASE("mpm svd: the polar rotation is the closest proper rotation") {
  std::mt19937 random(3);
  for (const Mat3d& F : matrices(2000)) {
    const Mat3d R = polar_rotation(F);
    const double best = squared_norm(F - R);
    // No rotation nearby, nor any random one, is closer; the slack is rounding.
    for (int k = 0; k < 5; ++k) {
      CHECK(squared_norm(F - rotation(random)) >= best - 1e-12 * (1 + squared_norm(F)));
    }
  }
}

TEST_CASE("mpm lanes: logarithm and exponential are accurate over their range") {
  using V = Lanes<float>;
  using D = Lanes<double>;
  double log_error = 0, exp_error = 0, log_error_double = 0, exp_error_double = 0;
  for (int i = 0; i < 40000; ++i) {
    const float x = std::pow(10.0f, -30.0f + 60.0f * static_cast<float>(i) / 40000.0f);
    const float near_one = 1.0f + 1e-3f * (static_cast<float>(i) / 20000.0f - 1.0f);
    for (const float a : {x, near_one}) {
      const double exact = std::log(double(a));
      log_error =
          std::max(log_error, std::fabs(double(natural_log(V(a))[0]) - exact) / std::max(std::fabs(exact), 1e-30));
      const double b = a;
      log_error_double = std::max(log_error_double, std::fabs(double(natural_log(D(b))[0]) - std::log(b)) /
                                                        std::max(std::fabs(std::log(b)), 1e-30));
    }
    const float y = -80.0f + 160.0f * static_cast<float>(i) / 40000.0f;
    exp_error = std::max(exp_error, std::fabs(double(exponential(V(y))[0]) / std::exp(double(y)) - 1));
    const double z = 8.5 * y;
    exp_error_double = std::max(exp_error_double, std::fabs(double(exponential(D(z))[0]) / std::exp(z) - 1));
  }
  // Two or three roundings of the last operations.
  CHECK(log_error < 3 * double(kEpsilon<float>));
  CHECK(exp_error < 3 * double(kEpsilon<float>));
  CHECK(log_error_double < 3 * kEpsilon<double>);
  CHECK(exp_error_double < 3 * kEpsilon<double>);
  CHECK(float(natural_log(V(1.0f))[0]) == 0.0f);
  CHECK(float(exponential(V(0.0f))[0]) == 1.0f);
}

TEST_CASE("mpm svd: lanes give what plain numbers give") {
  const std::vector<Mat3d> all = matrices(4000);
  using V = Lanes<double>;
  double difference = 0;
  for (size_t first = 0; first + V::size() <= all.size(); first += V::size()) {
    Mat3<V> F;
    for (size_t l = 0; l < V::size(); ++l)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) F[i][j][l] = all[first + l][i][j];
    const Svd<V> d = svd(F);
    for (size_t l = 0; l < V::size(); ++l) {
      const Svd<double> one = svd(all[first + l]);
      for (int i = 0; i < 3; ++i) {
        difference = std::max(difference, std::fabs(one.s[i] - double(d.s[i][l])) / std::max(one.s.x, 1e-300));
      }
    }
  }
  // Lanes may take one sweep more than they need.
  CHECK(difference < 32 * kEpsilon<double>);
}
