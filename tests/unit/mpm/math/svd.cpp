// Singular values and polar rotations against Eigen.
#include "mpm/math/svd.h"

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

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

// Kinds of matrices: plain random, prescribed singular values (repeated, near-singular, rank-deficient, inverted),
// nearly equal and graded values, and both at sizes from tiny to huge. Kept cheap: a million of them per type.
class MatrixSource {
 public:
  Mat3d next() {
    const double size = kSizes[index_ / 4 % 9];
    const int kind = index_++ % 4;
    Mat3d a;
    for (int i = 0; i < 3; ++i) a[i] = {uniform(), uniform(), uniform()};
    if (kind == 0) return size * a;
    Vec3d s;
    for (int i = 0; i < 3; ++i) {
      const int k = static_cast<int>(11.999 * (0.5 * uniform() + 0.5));
      // Rungs; values that differ by a few roundings; values that are orders of magnitude apart.
      s[i] = kind == 1   ? kRungs[k]
             : kind == 2 ? 1 + 1e-15 * static_cast<double>(k * k * k)
                         : (k % 2 ? 1 : -1) * std::pow(10.0, -1.3 * k);
    }
    return size * product(turn(), s, turn());
  }

 private:
  double uniform() { return static_cast<double>(random_()) * (2.0 / 4294967295.0) - 1; }
  Mat3d turn() {
    const double x = uniform(), y = uniform(), z = uniform(), w = uniform() + 1e-9;
    const double k = 2 / (x * x + y * y + z * z + w * w);
    return {{{1 - k * (y * y + z * z), k * (x * y - z * w), k * (x * z + y * w)},
             {k * (x * y + z * w), 1 - k * (x * x + z * z), k * (y * z - x * w)},
             {k * (x * z - y * w), k * (y * z + x * w), 1 - k * (x * x + y * y)}}};
  }
  static constexpr double kRungs[12] = {0, 1e-12, 1e-7, 1e-3, 0.5, 1, 1 + 1e-7, 2, 1e4, -1e-7, -0.5, -1};
  static constexpr double kSizes[9] = {1, 1e-30, 1, 1e30, 1, 1e-8, 1, 1e8, 1};
  std::mt19937 random_{11};
  int index_ = 0;
};

// Largest errors over a million matrices, one per lane, in units of the type's rounding and the size of the matrix.
template <class T>
void check_svd() {
  using V = Lanes<T>;
  constexpr int W = kLanes<T>;
  const std::vector<Mat3d> corners = matrices(20000);  // with the hand-picked ones
  constexpr int kCount = 1000000;
  constexpr int kCompared = 8;  // every eighth goes through Eigen as well
  MatrixSource source;
  double reconstruction = 0, orthogonality = 0, values = 0, handedness = 0;
  bool ordered = true;
  const double rounding = kEpsilon<T>;
  const int total = kCount + static_cast<int>(corners.size());
  for (int first = 0; first < total; first += W) {
    alignas(64) T entry[9][W];
    Mat3<T> F[W];
    for (int l = 0; l < W; ++l) {
      const int i = std::min(first + l, total - 1);
      F[l] = cast<T>(i < kCount ? source.next() : corners[i - kCount]);
      for (int k = 0; k < 9; ++k) entry[k][l] = F[l][k / 3][k % 3];
    }
    Mat3<V> lanes;
    for (int k = 0; k < 9; ++k) lanes[k / 3][k % 3] = V(entry[k], stdx::vector_aligned);
    const Svd<V> d = svd(lanes);
    for (int l = 0; l < W; ++l) {
      Mat3d u, vt;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) u[i][j] = d.U[i][j][l], vt[i][j] = d.Vt[i][j][l];
      }
      const Vec3d sigma = {double(d.s.x[l]), double(d.s.y[l]), double(d.s.z[l])};
      const Mat3d f = cast<double>(F[l]);
      const double largest = at_least(largest_entry(f), double(std::numeric_limits<T>::min()));
      // Scaled first: squares of huge numbers leave the range.
      const Mat3d rest = (1 / largest) * (product(u, sigma, vt) - f);
      // Subnormal matrices count as zero.
      const double unit = rounding * std::max(1.0, std::sqrt(squared_norm((1 / largest) * f)));
      if (largest_entry(f) >= double(std::numeric_limits<T>::min())) {
        reconstruction = std::max(reconstruction, std::sqrt(squared_norm(rest)) / unit);
      }
      orthogonality = std::max({orthogonality, squared_norm(times_transposed(u, u) - identity<double>()),
                                squared_norm(times_transposed(vt, vt) - identity<double>())});
      handedness = std::max({handedness, std::fabs(determinant(u) - 1), std::fabs(determinant(vt) - 1)});
      // Values below the root of the smallest number that counts are zero, in any order.
      const double slack = 2 * std::sqrt(double(kTiny<T>)) * sigma.x + double(std::numeric_limits<T>::min());
      ordered = ordered && sigma.x >= sigma.y * (1 - 16 * rounding);
      ordered = ordered && sigma.y >= std::fabs(sigma.z) * (1 - 16 * rounding) - slack;
      if ((first + l) % kCompared != 0 && first + l < kCount) continue;
      Eigen::Matrix3d reference;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) reference(i, j) = f[i][j];
      const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3d>(reference).singularValues();
      for (int i = 0; i < 3; ++i) {
        values = std::max(values, std::fabs(std::fabs(sigma[i]) - s[i]) /
                                      (rounding * std::max(s[0], double(std::numeric_limits<T>::min()) / rounding)));
      }
    }
  }
  INFO("reconstruction ", reconstruction, ", values ", values, ", orthogonality ", std::sqrt(orthogonality) / rounding,
       ", determinant ", handedness / rounding);
  // A dozen rotations of a few roundings each; measured 7, 4, 12, 11 in float and 9, 11, 16, 14 in double.
  CHECK(reconstruction < 32);
  CHECK(values < 32);
  CHECK(std::sqrt(orthogonality) < 32 * rounding);
  CHECK(handedness < 32 * rounding);
  CHECK(ordered);
}

}  // namespace

TEST_CASE(
    "mpm svd: reconstruction, singular values and proper rotations agree with Eigen, a million matrices each in float "
    "and double") {
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
