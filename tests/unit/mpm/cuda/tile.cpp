// Transfers between a particle and its tile against plain sums, and the whole numbers that sums are kept in.
#include "mpm/cuda/tile.h"

#include <doctest/doctest.h>

#include <climits>
#include <random>

using namespace physmas::mpm;
using namespace physmas::mpm::emulated_gpu;

namespace {

// Quadratic B-spline.
double spline(double distance) {
  const double d = std::fabs(distance);
  return d < 0.5 ? 0.75 - d * d : d < 1.5 ? 0.5 * (1.5 - d) * (1.5 - d) : 0;
}

// Calls function(x, y, z, weight, offset) for every node of a tile that a particle at x reaches.
template <class Function>
void for_each_node(const Vec3d& x, const Function& function) {
  for (int i = -1; i < kTile - 1; ++i) {
    for (int j = -1; j < kTile - 1; ++j) {
      for (int k = -1; k < kTile - 1; ++k) {
        const Vec3d offset = Vec3d{double(i), double(j), double(k)} - x;
        const double w = spline(offset.x) * spline(offset.y) * spline(offset.z);
        if (w > 0) function(i, j, k, w, offset);
      }
    }
  }
}

Vec3d anywhere(std::mt19937& random) {
  std::uniform_real_distribution<double> inside(-0.49, 5.49);  // a cell farther than the block's own
  return {inside(random), inside(random), inside(random)};
}

}  // namespace

TEST_CASE("mpm gpu tile: gathering is the weighted sum of velocities and of their first moments") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<NodeVelocity<double>> tile(kVelocityTile);
  for (auto& node : tile) node = {{uniform(random), uniform(random), uniform(random)}, 0};
  for (int round = 0; round < 100; ++round) {
    const Vec3d x = anywhere(random);
    Vec3d v, expected_v = {0, 0, 0};
    Mat3d moment, expected = diagonal(0.0, 0.0, 0.0);
    gather(tile.data(), stencil_of(x), v, moment);
    for_each_node(x, [&](int i, int j, int k, double w, const Vec3d& offset) {
      const NodeVelocity<double>& node = tile[(i + 1) * kVelocityX + (j + 1) * kVelocityY + (k + 1)];
      for (int c = 0; c < 3; ++c) {
        expected_v[c] += w * node.u[c];
        expected[c] = expected[c] + (w * node.u[c]) * offset;
      }
    });
    CHECK(norm(v - expected_v) < 1e-13);
    CHECK(std::sqrt(squared_norm(moment - expected)) < 1e-13);
  }
}

TEST_CASE("mpm gpu tile: scattering gives every node its share of momentum and mass") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 100; ++round) {
    const Vec3d x = anywhere(random);
    Gift<double> gift;
    gift.mass = 2 + uniform(random);
    for (int c = 0; c < 3; ++c) {
      gift.momentum[c] = uniform(random);
      for (int axis = 0; axis < 3; ++axis) gift.slope[c][axis] = uniform(random);
    }
    const Stencil<double> s = stencil_of(x);
    double received[kTile][kTile][kTile][4] = {};
    scatter(s, gift, [&](int i, int j, int k, const double* momentum, double mass) {
      double* const node = received[s.base[0] + 1 + i][s.base[1] + 1 + j][s.base[2] + 1 + k];
      for (int c = 0; c < 3; ++c) node[c] += momentum[c];
      node[3] += mass;
    });
    double worst = 0, mass_of_all = 0;
    for_each_node(x, [&](int i, int j, int k, double w, const Vec3d& offset) {
      const double* const node = received[i + 1][j + 1][k + 1];
      const Vec3d expected = w * (gift.momentum + gift.slope * offset);
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::fabs(node[c] - expected[c]));
      worst = std::max(worst, std::fabs(node[3] - w * gift.mass));
      mass_of_all += node[3];
    });
    CHECK(worst < 1e-13);
    CHECK(mass_of_all == doctest::Approx(gift.mass).epsilon(1e-12));
  }
}

TEST_CASE("mpm gpu tile: a full item's sums fit an int at every scale, and use most of it") {
  for (float bound = 1e-30f; bound < 1e30f; bound *= 1.37f) {
    const IntScale scale = int_scale(bits_of(bound));
    const double largest = 0.75 * 0.75 * 0.75 * bound * scale.scale + 0.5;
    CHECK(kMostInItem * largest < INT_MAX);
    if (bound > 1e-25f) CHECK(kMostInItem * largest > INT_MAX / 4.0);
    CHECK(scale.scale == std::ldexp(1.0f, scale.exponent));
  }
}

TEST_CASE("mpm gpu tile: shifts round to the nearest unit, and no number is too wild") {
  CHECK(shifted(5, 3) == 40);
  CHECK(shifted(-5, 3) == -40);
  CHECK(shifted(INT_MIN, 30) == -(1LL << 61));
  CHECK(shifted(5, -1) == 3);  // 2.5
  CHECK(shifted(5, -2) == 1);  // 1.25
  CHECK(shifted(-5, -2) == -1);
  CHECK(shifted(7, -2) == 2);  // 1.75
  CHECK(shifted(123456789, -200) == 0);
  CHECK(nearest_int(2.5e9f) == INT_MAX);
  CHECK(nearest_int(-2.5e9f) == INT_MIN);
  CHECK(nearest_int(std::nanf("")) == 0);
  CHECK(nearest_long(1e300) == LLONG_MAX);
  CHECK(nearest_long(-1e300) == LLONG_MIN);
  // Where a particle is does not lead outside the tile.
  for (const double x : {-1e30, 1e30, double(NAN), -7.0, 12.0}) {
    const Stencil<double> s = stencil_of(Vec3d{x, 1, 1});
    CHECK(s.base[0] >= -1);
    CHECK(s.base[0] + 2 < kTile - 1);
  }
}
