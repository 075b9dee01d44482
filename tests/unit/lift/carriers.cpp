// More Gaussians than particles.
#include "lift/carriers.h"

#include <doctest/doctest.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <set>

#include "records/rollout.h"
#include "splat/rollout_frames.h"

using namespace physmas;
using namespace physmas::lift;

namespace {

struct Cloud {
  std::vector<Eigen::Vector3f> means;
  std::vector<int32_t> row;
};

// A slab of 0.8 x 0.8 x 0.1, of which one end holds nine tenths of the Gaussians, and a small ball of row 2 inside.
Cloud uneven_cloud() {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  Cloud cloud;
  for (int i = 0; i < 20000; ++i) {
    const float x = i % 10 == 0 ? unit(random) : 0.1f * unit(random);
    cloud.means.push_back({0.6f + 0.8f * x, 0.6f + 0.8f * unit(random), 1 + 0.1f * unit(random)});
    cloud.row.push_back(0);
  }
  for (int i = 0; i < 200; ++i) {
    cloud.means.push_back(Eigen::Vector3f(1, 1, 1.05f) + 0.01f * Eigen::Vector3f::Random());
    cloud.row.push_back(2);
  }
  return cloud;
}

}  // namespace

TEST_CASE("lift: carriers are as many as asked for, in order, of every row, and lie where there is matter") {
  const Cloud cloud = uneven_cloud();
  for (const size_t count : {size_t{2}, size_t{500}, size_t{3000}, cloud.means.size()}) {
    const std::vector<int32_t> chosen = choose_carriers(cloud.means, cloud.row, count, 2);
    REQUIRE(chosen.size() == count);
    std::set<int32_t> rows;
    for (size_t q = 0; q < count; ++q) {
      if (q > 0) CHECK(chosen[q] > chosen[q - 1]);
      rows.insert(cloud.row[chosen[q]]);
    }
    CHECK(rows == std::set<int32_t>{0, 2});
  }
  // The dense end takes up a ninth of the rest's room and has nine times as many Gaussians: it has no more than half of
  // the carriers, where taking every n-th would give it nine tenths.
  const std::vector<int32_t> chosen = choose_carriers(cloud.means, cloud.row, 1000, 2);
  long dense = 0;
  for (const int32_t g : chosen) dense += cloud.row[g] == 0 && cloud.means[g].x() < 0.68f ? 1 : 0;
  CHECK(dense < 500);
  CHECK(dense > 50);
  // No Gaussian is far from a carrier.
  for (size_t i = 0; i < cloud.means.size(); ++i) {
    float least = INFINITY;
    for (const int32_t g : chosen) {
      if (cloud.row[g] == cloud.row[i]) least = std::min(least, (cloud.means[g] - cloud.means[i]).norm());
    }
    CHECK(least < 0.12f);
  }
}

TEST_CASE("lift: the same carriers whatever the number of threads") {
  const Cloud cloud = uneven_cloud();
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Carriers one = carry(cloud.means, cloud.row, choose_carriers(cloud.means, cloud.row, 700, 2));
  omp_set_num_threads(4);
  const Carriers four = carry(cloud.means, cloud.row, choose_carriers(cloud.means, cloud.row, 700, 2));
  omp_set_num_threads(threads);
  CHECK(one.gaussian == four.gaussian);
  CHECK(one.particle == four.particle);
  CHECK(one.weight == four.weight);
}

TEST_CASE("lift: carriers of the same row move the others as a whole") {
  const Cloud cloud = uneven_cloud();
  Carriers carriers = carry(cloud.means, cloud.row, choose_carriers(cloud.means, cloud.row, 300, 2));
  constexpr int kPer = Carriers::kPerGaussian;
  for (size_t i = 0; i < cloud.means.size(); ++i) {
    double sum = 0;
    for (int k = 0; k < kPer; ++k) {
      CHECK(cloud.row[carriers.gaussian[carriers.particle[i * kPer + k]]] == cloud.row[i]);
      sum += carriers.weight[i * kPer + k];
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-5));
  }
  // Row 0 is turned, stretched and moved; row 2 stays.
  const Eigen::Matrix3f A = Eigen::AngleAxisf(0.7f, Eigen::Vector3f(1, 2, 3).normalized()).toRotationMatrix() *
                            Eigen::Vector3f(1.3f, 0.8f, 1.1f).asDiagonal();
  const Eigen::Vector3f b(0.1f, -0.2f, 0.3f);
  RolloutFrame frame;
  for (const int32_t g : carriers.gaussian) {
    const bool moved = cloud.row[g] == 0;
    const Eigen::Vector3f x = moved ? Eigen::Vector3f(A * cloud.means[g] + b) : cloud.means[g];
    const Eigen::Matrix3f F = moved ? A : Eigen::Matrix3f::Identity();
    for (int a = 0; a < 3; ++a) frame.position.push_back(x[a]);
    for (int a = 0; a < 9; ++a) frame.F.push_back(F(a / 3, a % 3));
  }
  SolverMap map;
  map.s = 0.5;
  map.d = {1, 0, 0};
  const splat::TransportedFrame transported(frame, map, carriers);
  for (size_t i = 0; i < cloud.means.size(); ++i) {
    const bool moved = cloud.row[i] == 0;
    const Eigen::Vector3f x = moved ? Eigen::Vector3f(A * cloud.means[i] + b) : cloud.means[i];
    CHECK((transported.position(i) - map.to_scene(x.cast<double>()).cast<float>()).norm() < 1e-5f);
    CHECK((transported.F(i) - (moved ? A : Eigen::Matrix3f::Identity())).norm() < 1e-5f);
  }
}
