// Companions on fewer cells, and the error that is estimated with them.
#include "studies/discretisation_error.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include "studies/error_cases.h"
#include "studies/error_study.h"
#include "studies/verification_cases.h"

using namespace physmas;
using namespace physmas::studies;
using mpm::Vec3d;

namespace {

// Points that are off by c h^p in a run with cells of edge h, growing evenly in time.
RefinedPaths off_by(double p, size_t points, int frames, double error) {
  RefinedPaths paths;
  PointPaths* all[] = {&paths.fine, &paths.half, &paths.quarter};
  for (int level = 0; level < 3; ++level) {
    for (int t = 0; t < frames; ++t) {
      const double off = error * t / (frames - 1) * std::exp2(level * p);
      all[level]->push_back(std::vector<Vec3d>(points, Vec3d{1 + off, 2, 3}));
    }
  }
  return paths;
}

}  // namespace

TEST_CASE("companion: mass and momentum of every row and the centre of mass are kept, on half of the cells") {
  for (AccuracyCase& c : further_cases(1.0 / 24)) {
    CAPTURE(c.name);
    c.problem.domain.n = 48;
    const Companion companion = make_companion(c.problem, 2);
    const mpm::Particles &fine = c.problem.particles, &coarse = companion.problem.particles;
    CHECK(companion.problem.domain.n == 24);
    CHECK(companion.problem.domain.wall_cells * companion.problem.domain.dx() >=
          c.problem.domain.wall_cells * c.problem.domain.dx());
    REQUIRE(companion.group.size() == fine.size());
    CHECK(coarse.size() < fine.size() / 3);
    for (size_t row = 0; row < c.problem.materials.size(); ++row) {
      double volume[2] = {};
      Vec3d moment[2] = {}, momentum[2] = {};
      for (int k = 0; k < 2; ++k) {
        const mpm::Particles& p = k == 0 ? fine : coarse;
        for (size_t i = 0; i < p.size(); ++i) {
          if (p.row[i] != static_cast<int>(row)) continue;
          volume[k] += p.volume[i];
          moment[k] = moment[k] + p.volume[i] * p.position[i];
          momentum[k] = momentum[k] + p.volume[i] * p.velocity[i];
        }
      }
      CHECK(volume[1] == doctest::Approx(volume[0]).epsilon(1e-12));
      CHECK(norm(moment[1] - moment[0]) < 1e-12 * norm(moment[0]));
      CHECK(norm(momentum[1] - momentum[0]) <= 1e-12 * norm(momentum[0]));
    }
    for (size_t i = 0; i < fine.size(); ++i) CHECK(coarse.row[companion.group[i]] == fine.row[i]);
  }
}

TEST_CASE("companion: points that turn with a rigid body stay where the body has them") {
  mpm::Problem p;
  p.domain.gravity = {0, 0, 0};
  p.domain.n = 48;
  p.materials = {{mpm::Branch::jelly, 1e5, 0.3, 1000}};
  seed(p, {0.803, 0.797, 0.803}, {1.203, 1.197, 1.203}, 1.0 / 48, 0);
  for (Vec3d& v : p.particles.velocity) v = {0.5, 0, 0.25};
  mpm::Timing timing;
  timing.frames = 3, timing.frame_dt = 0.1, timing.rule = mpm::StepRule::cfl, timing.substeps = 100;
  const PointPaths paths = run_companion(make_companion(p, 2), p.particles, p.particles.size(), timing, {});
  REQUIRE(paths.size() == 3);
  // In float, after two frames of uniform motion.
  for (size_t i = 0; i < p.particles.size(); ++i)
    CHECK(norm(paths[2][i] - (p.particles.position[i] + 0.2 * Vec3d{0.5, 0, 0.25})) < 1e-5);
}

TEST_CASE(
    "error estimate: first order is found exactly, half an order for what falls apart, and the order is observed") {
  const std::vector<int> row_of(20, 0);
  // The root mean square of t / T over 7 frames.
  const double rms = std::sqrt((0 + 1 + 4 + 9 + 16 + 25 + 36) / 36.0 / 7);
  for (const double p : {0.5, 1.0}) {
    const ErrorEstimate e = position_error(off_by(p, 20, 7, 1e-3), row_of, -1, {p});
    CHECK(e.estimate == doctest::Approx(1e-3 * rms).epsilon(1e-9));
    CHECK(e.order == doctest::Approx(p).epsilon(1e-9));
    CHECK(e.lowest_order == doctest::Approx(p).epsilon(1e-9));
    CHECK(e.highest_order == doctest::Approx(p).epsilon(1e-9));
    CHECK(e.bound >= e.estimate);
  }
  // What converges faster is not trusted to: the estimate is that of first order, three times too high here.
  const ErrorEstimate second = position_error(off_by(2, 20, 7, 1e-3), row_of, -1, {1});
  CHECK(second.estimate == doctest::Approx(3e-3 * rms).epsilon(1e-9));
  CHECK(second.order == doctest::Approx(2).epsilon(1e-9));
  // Companions that agree with each other but not with the run: not regular, and the bound is by the larger difference.
  RefinedPaths irregular = off_by(1, 20, 7, 1e-3);
  irregular.quarter = irregular.half;
  const ErrorEstimate e = position_error(irregular, row_of, -1, {1});
  CHECK_FALSE(e.regular);
  CHECK(e.bound == doctest::Approx(2 * e.difference));
}

TEST_CASE("error estimate: rows are measured apart, and without points or motion there is none") {
  RefinedPaths paths = off_by(1, 4, 5, 1e-3);
  std::vector<int> row_of = {0, 0, 1, 1};
  for (PointPaths* path : {&paths.half, &paths.quarter}) {
    for (std::vector<Vec3d>& x : *path) x[0] = x[1] = {1, 2, 3};
  }
  for (std::vector<Vec3d>& x : paths.fine) x[0] = x[1] = {1, 2, 3};
  CHECK(position_error(paths, row_of, 0, {1, 1}).estimate == 0);
  const double all = position_error(paths, row_of, -1, {1, 1}).estimate;
  CHECK(position_error(paths, row_of, 1, {1, 1}).estimate == doctest::Approx(std::sqrt(2.0) * all));
  CHECK_FALSE(position_error(paths, row_of, 2, {1, 1, 1}).reason.empty());
  paths.fine.resize(1), paths.half.resize(1), paths.quarter.resize(1);
  CHECK_FALSE(position_error(paths, row_of, -1, {1, 1}).reason.empty());
}

TEST_CASE("error estimate: free fall, whose error g t dt / 2 is known") {
  mpm::Problem p;
  p.domain.n = 48;
  p.materials = {{mpm::Branch::jelly, 1e5, 0.3, 1000}};
  seed(p, {0.853, 0.847, 1.2}, {1.053, 1.047, 1.4}, 1.0 / 48, 0);
  const double dt = 4e-4, g = norm(p.domain.gravity);
  RefinedPaths paths;
  PointPaths* all[] = {&paths.fine, &paths.half, &paths.quarter};
  for (int level = 0; level < 3; ++level) {
    mpm::Timing timing;
    timing.frames = 6, timing.frame_dt = 0.04;
    timing.substeps = static_cast<int>(std::lround(timing.frame_dt / dt)) >> level;
    const int factor = 1 << level;
    Companion companion = make_companion(p, std::max(2, factor));
    if (level == 0) {
      companion.problem = p;
      for (size_t i = 0; i < companion.group.size(); ++i) companion.group[i] = static_cast<int>(i);
    }
    *all[level] = run_companion(companion, p.particles, p.particles.size(), timing, {});
  }
  double squares = 0;
  for (int t = 0; t < 6; ++t) squares += std::pow(g * 0.04 * t * dt / 2, 2);
  const ErrorEstimate e = position_error(paths, p.particles.row, -1, {1});
  // Float positions are good to 1e-7; the error is 4e-4.
  CHECK(e.estimate == doctest::Approx(std::sqrt(squares / 6)).epsilon(0.01));
  CHECK(e.order == doctest::Approx(1).epsilon(0.01));
}

TEST_CASE("error study: the estimate is the truth within a factor of two where it can be checked in a second") {
  ErrorStudyPlan plan;
  plan.n = 32, plan.finer = 2, plan.dt = 4e-4;
  const ErrorStudyRow row = study_error(error_study_cases(1.0 / plan.n, true).front(), plan, {});
  CHECK(row.truth[0] < 2 * row.estimate[0].estimate);
  CHECK(row.truth[0] > 0.5 * row.estimate[0].estimate);
  CHECK(row.truth[0] < row.estimate[0].bound);
  const std::string table = error_study_table({row});
  CHECK(table.find("jelly-drop") != std::string::npos);
  CHECK(honesty({row}, 0).within_two == 1);
}
