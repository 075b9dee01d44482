// The total deformation gradient, which no return map touches.
#include <doctest/doctest.h>

#include <cstring>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

Problem pressed(Branch branch) {
  Problem p = scene({branch, 1e5, 0.3, 1000}, 32);
  add_block(p, {0.8, 0.8, 0.4}, {1.1, 1.1, 0.7}, 0, p.domain.dx());
  p.domain.colliders.push_back(floor_at(0.4));
  p.schedule.actions.push_back(TopPress{{0}, {0, 0, -0.6}, {0, 0, 1}, 0.15, 0, 0.16});
  return p;
}

}  // namespace

TEST_CASE("mpm total deformation: it is the elastic one where nothing yields, another where material flows") {
  for (const Precision precision : {Precision::full, Precision::single}) {
    for (const Branch branch : {Branch::jelly, Branch::metal, Branch::plasticine, Branch::sand, Branch::foam}) {
      CAPTURE(branch_name(branch));
      Options o = options(precision);
      o.track_total_F = true;
      const Outcome out = simulate(pressed(branch), {6, 0.04, 160}, o);
      REQUIRE(out.result.status == Status::stable);
      REQUIRE(out.state.total_F.size() == out.state.size());
      double difference = 0;
      bool positive = true;
      for (size_t i = 0; i < out.state.size(); ++i) {
        difference = std::max(difference, squared_norm(out.state.total_F[i] - out.state.F[i]));
        positive = positive && determinant(out.state.total_F[i]) > 0;
      }
      CHECK(positive);
      if (branch == Branch::jelly || branch == Branch::metal) {
        CHECK(difference == 0);  // the same operations on the same numbers
      } else {
        CHECK(difference > 0.01);
      }
    }
  }
}

TEST_CASE("mpm total deformation: tracking it changes nothing else, and it is absent when not asked for") {
  const Problem p = pressed(Branch::plasticine);
  Options o = options(Precision::single);
  const Outcome without = simulate(p, {4, 0.04, 160}, o);
  o.track_total_F = true;
  const Outcome with = simulate(p, {4, 0.04, 160}, o);
  CHECK(without.state.total_F.empty());
  CHECK(std::memcmp(with.state.x.data(), without.state.x.data(), p.particles.size() * sizeof(Vec3d)) == 0);
  CHECK(std::memcmp(with.state.F.data(), without.state.F.data(), p.particles.size() * sizeof(Mat3d)) == 0);
}

TEST_CASE("mpm total deformation: structure projection relaxes it with the elastic one") {
  Problem p = pressed(Branch::plasticine);
  p.schedule.projections.push_back({0, 1.0});
  Options o = options();
  o.track_total_F = true;
  const Outcome out = simulate(p, {3, 0.04, 160}, o);
  for (const Mat3d& F : out.state.total_F) CHECK(squared_norm(F - identity<double>()) == 0);
}
