#include "lift/filling.h"

#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "lift/initial_state.h"
#include "scene/placement.h"

using namespace physmas;
using namespace physmas::lift;
using Verdict = Filling::Report::Verdict;

namespace {

// Gaussians of standard deviation `sigma` at `points`.
Gaussians cloud(const std::vector<Eigen::Vector3f>& points, float sigma) {
  Gaussians g;
  g.resize(points.size(), 0);
  g.position = points;
  for (Eigen::Vector3f& s : g.log_scale) s.setConstant(std::log(sigma));
  for (float& o : g.opacity_logit) o = 3;
  return g;
}

// Evenly spread on a sphere (golden spiral).
std::vector<Eigen::Vector3f> sphere(int count, float radius) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), a = i * M_PI * (3 - std::sqrt(5.0));
    points.push_back(radius * Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z).cast<float>());
  }
  return points;
}

std::vector<Eigen::Vector3f> box_shell(int n) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const float a = static_cast<float>(i) / n, b = static_cast<float>(j) / n;
      for (const float c : {0.0f, 1.0f}) {
        points.push_back({a, b, c});
        points.push_back({a, c, b});
        points.push_back({c, a, b});
      }
    }
  }
  return points;
}

RunSpecification run_with(int n, int per_cell, int max = 200000) {
  RunSpecification run;
  run.grid.n = n;
  run.particles.per_cell = per_cell;
  run.particles.max = max;
  return run;
}

Inventory one_part() {
  Inventory inventory;
  inventory.objects.resize(1);
  inventory.objects[0].id = "thing";
  InventoryRow row;
  row.object = row.part = "thing";
  inventory.rows = {row, row};
  inventory.rows[1].part = "residual";
  inventory.rows[1].residual = true;
  return inventory;
}

State state_of(const Gaussians& g, const RunSpecification& run) {
  Labels labels;
  labels.object.assign(g.size(), 0);
  labels.row.assign(g.size(), 0);
  labels.confidence.assign(g.size(), 1);
  return initial_state(g, labels, one_part(), run, "scene.ply");
}

Filling fill(const Gaussians& g, const RunSpecification& run) {
  const SolverMap map = solver_map(g, run);
  std::vector<Eigen::Vector3f> means;
  for (const Eigen::Vector3f& p : g.position) means.push_back(map.to_solver(p.cast<double>()).cast<float>());
  return fill_objects(g, means, std::vector<int32_t>(g.size(), 0), 1, map, run);
}

}  // namespace

TEST_CASE("lift: a hollow sphere is filled to its volume") {
  const RunSpecification run = run_with(100, 8, 1000000);
  const Gaussians g = cloud(sphere(8000, 1), 0.03f);
  const Filling filling = fill(g, run);
  REQUIRE(filling.objects[0].verdict == Verdict::filled);
  // Diameter 1 in solver space.
  const double analytic = 4.0 / 3 * M_PI * 0.125;
  const double filled = static_cast<double>(filling.position.size()) * std::pow(filling.spacing, 3);
  CHECK(filled > 0.85 * analytic);
  CHECK(filled < 1.0 * analytic);
  for (const Eigen::Vector3f& p : filling.position) CHECK((p - Eigen::Vector3f::Ones()).norm() < 0.5f);
}

TEST_CASE("lift: what one object encloses inside another belongs to the inner one, whichever comes first") {
  std::vector<Eigen::Vector3f> points = sphere(8000, 1), inner = sphere(2000, 0.5f);
  points.insert(points.end(), inner.begin(), inner.end());
  const Gaussians g = cloud(points, 0.03f);
  const RunSpecification run = run_with(60, 8, 1000000);
  const SolverMap map = solver_map(g, run);
  std::vector<Eigen::Vector3f> means;
  for (const Eigen::Vector3f& p : g.position) means.push_back(map.to_solver(p.cast<double>()).cast<float>());
  for (const int32_t of_inner : {0, 1}) {
    CAPTURE(of_inner);
    std::vector<int32_t> object(g.size(), 1 - of_inner);
    std::fill(object.begin() + 8000, object.end(), of_inner);
    const Filling filling = fill_objects(g, means, object, 2, map, run);
    std::vector<long> within(2, 0);
    for (size_t q = 0; q < filling.position.size(); ++q) {
      // The outer radius is 0.5 in solver space.
      const bool inside = (filling.position[q] - Eigen::Vector3f::Ones()).norm() < 0.25f;
      CHECK(filling.object[q] == (inside ? of_inner : 1 - of_inner));
      ++within[inside ? 0 : 1];
    }
    CHECK(within[0] > 500);
    CHECK(within[1] > 5000);
  }
}

TEST_CASE("lift: a hollow box is filled to its volume, whatever the density") {
  const Gaussians g = cloud(box_shell(40), 0.015f);
  for (const int per_cell : {1, 4, 8, 27}) {
    CAPTURE(per_cell);
    const RunSpecification run = run_with(40, per_cell);
    const Filling filling = fill(g, run);
    REQUIRE(filling.objects[0].verdict == Verdict::filled);
    const double per_volume = per_cell / std::pow(run.grid.dx(), 3);
    const double share = static_cast<double>(filling.position.size()) / per_volume;
    CHECK(share > 0.7);
    CHECK(share < 1.05);
  }
}

TEST_CASE("lift: sheets and open shapes enclose nothing") {
  std::vector<Eigen::Vector3f> sheet, cup;
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 60; ++j) sheet.push_back({i / 60.0f, j / 60.0f, 0});
  }
  for (const Eigen::Vector3f& p : sphere(6000, 1)) {
    if (p.z() < 0) cup.push_back(p);
  }
  CHECK(fill(cloud(sheet, 0.012f), run_with(60, 8)).objects[0].verdict == Verdict::open);
  const Filling bowl = fill(cloud(cup, 0.03f), run_with(60, 8));
  CHECK(bowl.position.size() < 200);
}

TEST_CASE("lift: an object that is solid already is not filled, and the state says so") {
  std::vector<Eigen::Vector3f> points;
  for (int x = 0; x < 24; ++x) {
    for (int y = 0; y < 24; ++y) {
      for (int z = 0; z < 24; ++z) points.push_back(Eigen::Vector3f(x, y, z) / 24);
    }
  }
  const State state = state_of(cloud(points, 0.03f), run_with(40, 8));
  CHECK(state.particle_count() == points.size());
  REQUIRE(state.omitted.size() == 1);
  CHECK(state.omitted[0].why.find("solid") != std::string::npos);
}

TEST_CASE("lift: filled particles take source and row from the nearest Gaussian, and stay inside the limit") {
  const Gaussians g = cloud(sphere(3000, 1), 0.05f);
  const State all = state_of(g, run_with(50, 8));
  CHECK(all.particle_count() > g.size() + 5000);
  for (size_t q = 0; q < all.particle_count(); q += 97) {
    double best = 1e9;
    int32_t nearest = -1;
    for (size_t i = 0; i < g.size(); ++i) {
      const double d = (all.position[q].cast<double>() - all.position[i].cast<double>()).squaredNorm();
      if (d < best) {
        best = d;
        nearest = static_cast<int32_t>(i);
      }
    }
    CHECK(all.source[q] == nearest);
    CHECK(all.row[q] == 0);
  }
  const State few = state_of(g, run_with(50, 8, 5000));
  CHECK(few.particle_count() == 5000);
  CHECK(few.omitted.size() == 1);
  // Thinned evenly: the centre of mass of what was added stays in the middle.
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (size_t q = g.size(); q < few.particle_count(); ++q) mean += few.position[q];
  CHECK((mean / static_cast<float>(few.particle_count() - g.size()) - Eigen::Vector3f::Ones()).norm() < 0.02f);
  // More Gaussians than particles: half of the limit carries them, the other half is filled.
  const State carried = state_of(g, run_with(50, 8, 2999));
  CHECK(carried.gaussian_count() == 3000);
  CHECK(carried.carrier_count() == 1500);
  CHECK(carried.particle_count() == 2999);
  for (size_t q = 0; q < 1500; ++q) {
    CHECK(carried.source[q] == carried.carriers.gaussian[q]);
    CHECK(carried.position[q] == all.position[carried.source[q]]);
  }
  CHECK(all.carriers.empty());
}

TEST_CASE("lift: rest volumes share out the occupied cells") {
  SolverMap map;
  map.n = 10;
  map.length = 2;
  const std::vector<Eigen::Vector3f> points = {
      {0.1f, 0.1f, 0.1f}, {0.15f, 0.1f, 0.1f}, {0.5f, 0.5f, 0.5f}, {1.99f, 1.99f, 1.99f}};
  const std::vector<float> volume = rest_volumes(points, map);
  CHECK(volume[0] == doctest::Approx(0.004));
  CHECK(volume[1] == doctest::Approx(0.004));
  CHECK(volume[2] == doctest::Approx(0.008));
  CHECK(std::accumulate(volume.begin(), volume.end(), 0.0) == doctest::Approx(3 * 0.008));
}

TEST_CASE("lift: a filled sphere weighs about what a sphere weighs") {
  const State state = state_of(cloud(sphere(8000, 1), 0.03f), run_with(100, 8, 1000000));
  const double volume = std::accumulate(state.volume.begin(), state.volume.end(), 0.0);
  const double analytic = 4.0 / 3 * M_PI * 0.125;
  CHECK(volume > analytic);
  CHECK(volume < 1.15 * analytic);  // the cells that the surface cuts count whole
}

TEST_CASE("lift: the filling does not depend on the number of threads") {
  const Gaussians g = cloud(sphere(3000, 1), 0.05f);
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const State one = state_of(g, run_with(50, 8));
  omp_set_num_threads(4);
  const State four = state_of(g, run_with(50, 8));
  omp_set_num_threads(before);
  CHECK(one.source == four.source);
  CHECK(one.volume == four.volume);
  CHECK(one.position == four.position);
}
