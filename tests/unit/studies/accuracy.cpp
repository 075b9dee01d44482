// The accuracy study: tracers, Pareto sets, silhouettes of points, and errors that fall when a run is refined.
#include "studies/accuracy.h"

#include <doctest/doctest.h>

#include "studies/point_tracks.h"

using namespace physmas;
using namespace physmas::studies;

namespace {

AccuracyResult timed(double seconds, double error, bool stable = true) {
  AccuracyResult r;
  r.stable = stable;
  r.median_seconds = seconds;
  r.error[0] = error;
  return r;
}

}  // namespace

TEST_CASE("accuracy: the eight particles of a subdivided one have its place, volume, row and velocity in the mean") {
  for (const AccuracyCase& c : accuracy_cases(1.0 / 16)) {
    const mpm::Problem fine = subdivide(c.problem, 1.0 / 16);
    REQUIRE(fine.particles.size() == 8 * c.problem.particles.size());
    REQUIRE(c.problem.particles.size() > 50);
    for (size_t i = 0; i < c.problem.particles.size(); ++i) {
      mpm::Vec3d x{0, 0, 0};
      double volume = 0;
      for (size_t k = 8 * i; k < 8 * i + 8; ++k) {
        x = x + 0.125 * fine.particles.position[k];
        volume += fine.particles.volume[k];
        CHECK(fine.particles.row[k] == c.problem.particles.row[i]);
      }
      CHECK(norm(x - c.problem.particles.position[i]) < 1e-15);
      CHECK(volume == doctest::Approx(c.problem.particles.volume[i]).epsilon(1e-15));
    }
  }
}

TEST_CASE("accuracy: Pareto-optimal is what nothing stable beats in both") {
  std::vector<AccuracyResult> r = {timed(1, 0.4), timed(2, 0.2),           timed(3, 0.3),
                                   timed(4, 0.1), timed(0.5, 0.05, false), timed(5, -1)};
  mark_pareto(r);
  const bool expected[] = {true, true, false, true, false, false};
  for (size_t i = 0; i < r.size(); ++i) CHECK(r[i].pareto[0] == expected[i]);
  for (const AccuracyResult& one : r) CHECK(!one.pareto[1]);  // never measured
}

TEST_CASE("accuracy: a disc of points covers its area, and the nearest point is tracked") {
  const Camera camera = look_at({0, -2, 0}, {0, 0, 0}, {0, 0, 1}, 0.5, 200, 200);
  std::vector<mpm::Vec3d> x = {{0, 0, 0}, {0, 1, 0}, {0.1, 0, 0.05}};  // the second hides behind the first
  PointTracker tracker(camera, 0.05);
  const std::vector<int> queries = tracker.choose_queries(x);
  CHECK(std::find(queries.begin(), queries.end(), 1) == queries.end());
  CHECK(queries.size() == 2);
  metrics::TargetMotion motion;
  tracker.add_frame({{0, 0, 0}}, {0}, motion);
  const double r = camera.fx * 0.05 / 2;
  CHECK(motion.areas[0] == doctest::Approx(3.14159 * r * r).epsilon(0.03));  // pixels at the rim
  CHECK(motion.tracks.position[0][0].x() == doctest::Approx(100));
  CHECK(motion.tracks.visible[0][0] == 1);
}

TEST_CASE("accuracy: a run that is refined comes closer to its reference") {
  AccuracyPlan plan;
  plan.spacing = 1.0 / 24;
  plan.reference_n = 32;
  plan.reference_dt = 2e-4;
  plan.repeats = 1;
  plan.settings = {{12, fixed_step(4e-4), mpm::Precision::single, {Device::Kind::cpu, 1}},
                   {24, fixed_step(4e-4), mpm::Precision::single, {Device::Kind::cpu, 1}},
                   {24, fixed_step(4e-2), mpm::Precision::single, {Device::Kind::cpu, 1}}};
  AccuracyCase c = accuracy_cases(plan.spacing).front();
  c.duration = 0.24;
  int calls = 0;
  const AccuracyStudy study = run_accuracy(c, plan, {Device::Kind::cpu, 1}, [&] { ++calls; });
  CHECK(calls == 5);
  REQUIRE(study.results.size() == 3);
  CHECK(study.reference.doubled_step[0] > 0);
  CHECK(study.reference.doubled_step[0] < study.results[0].error[0]);
  for (int m = 0; m < kAccuracyMetrics; ++m) {
    INFO(kAccuracyMetricNames[m]);
    CHECK(study.results[1].error[m] >= 0);
    CHECK(study.results[1].error[m] < study.results[0].error[m]);
  }
  CHECK(study.results[1].error[0] < 0.1);  // of the object's size
  CHECK(!study.results[2].stable);         // 20 ms steps cannot be integrated: said, not measured
  CHECK(study.results[2].error[0] == -1);
}
