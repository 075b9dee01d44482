// Rigid rows in the solver.
#include <doctest/doctest.h>

#include <cstring>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

const Material kStiff = {Branch::jelly, 1.7e10, 0.3, 2000}, kSoft = {Branch::jelly, 1e5, 0.3, 1000};
constexpr double kDx = 0.04;  // of scene(…, 50)

Options rigid_options(Precision precision = Precision::full, int threads = 2) {
  Options o = options(precision, threads);
  o.stiff = StiffRule::rigid;
  return o;
}

Problem stiff_block(const Vec3d& gravity, double height, const Vec3d& velocity) {
  Problem p = scene(kStiff, 50, gravity);
  const double edge = 6 * kDx;
  add_block(p, {0.8, 0.8, height}, {0.8 + edge, 0.8 + edge, height + edge}, 0, kDx, 0, velocity);
  return p;
}

double largest_change_of_shape(const Problem& p, const State& s) {
  double most = 0;
  const Vec3d &x0 = s.x.front(), &r0 = p.particles.position.front();
  for (size_t i = 0; i < s.size(); ++i) {
    most = std::max(most, std::fabs(norm(s.x[i] - x0) - norm(p.particles.position[i] - r0)));
  }
  return most;
}

}  // namespace

TEST_CASE("a stiff row falls freely as it should, without changing its shape, where explicit steps explode") {
  const Problem p = stiff_block({0, 0, -9.8}, 1.2, {0.5, 0, 0});
  const Timing t{6, 0.02, 100};
  CHECK(simulate(p, t, options()).result.status == Status::diverged);
  const Outcome out = simulate(p, t, rigid_options());
  REQUIRE(out.result.status == Status::stable);
  REQUIRE(out.result.stiff_rows.size() == 1);
  REQUIRE(out.result.rigid_bodies.size() == 1);
  const double time = 0.1;
  const Vec3d moved = mean(out.state.x) - mean(p.particles.position);
  CHECK(moved.x == doctest::Approx(0.05).epsilon(1e-9));
  // Symplectic Euler: half a step more than the parabola.
  CHECK(moved.z == doctest::Approx(-0.5 * 9.8 * time * (time + 2e-4)).epsilon(1e-9));
  CHECK(largest_change_of_shape(p, out.state) < 1e-12);
}

TEST_CASE("momentum and angular momentum of a rigid and a soft row that meet are kept to rounding") {
  Problem p = stiff_block({0, 0, 0}, 0.8, {1.5, 0, 0});
  p.materials.push_back(kSoft);
  p.object = {0, 1};
  add_block(p, {1.08, 0.85, 0.86}, {1.32, 1.05, 1.1}, 1, kDx);
  const Outcome out = simulate(p, {6, 0.02, 100}, rigid_options());
  REQUIRE(out.result.status == Status::stable);
  const Balance &first = out.result.balances.front(), &last = out.result.balances.back();
  CHECK(norm(last.momentum - first.momentum) < 1e-11 * norm(first.momentum));
  CHECK(norm(last.angular_momentum - first.angular_momentum) < 1e-11 * norm(first.angular_momentum));
  // They did meet.
  CHECK(out.state.v.front().x < 1.2);
  CHECK(largest_change_of_shape(stiff_block({0, 0, 0}, 0.8, {0, 0, 0}), [&] {
          State stiff = out.state;
          stiff.x.resize(6 * 6 * 6 * 8);
          return stiff;
        }()) < 1e-12);
}

TEST_CASE("two rigid bodies that touch keep their momentum, met in a window or not") {
  Problem p = scene(kStiff, 50);
  p.materials.push_back(kStiff);
  p.object = {0, 1};
  add_block(p, {0.6, 0.8, 0.8}, {0.84, 1.04, 1.04}, 0, kDx, 0, {1, 0, 0});
  add_block(p, {0.94, 0.86, 0.84}, {1.18, 1.1, 1.08}, 1, kDx, 0, {-1, 0, 0});
  for (const double budget : {1.0, -1.0}) {
    Options o = rigid_options();
    o.impact_budget = budget;
    const Outcome out = simulate(p, {5, 0.02, 100}, o);
    REQUIRE(out.result.status == Status::stable);
    CHECK((out.result.impacts.windows > 0) == (budget > 0));
    const Balance &first = out.result.balances.front(), &last = out.result.balances.back();
    CHECK(norm(last.momentum - first.momentum) < 1e-11 * first.mass);
    CHECK(norm(last.angular_momentum - first.angular_momentum) < 1e-11 * first.mass);
    CHECK(last.kinetic < 0.7 * first.kinetic);
  }
}

TEST_CASE("a stiff cube bounces as its material does, and rests on a floor without sinking") {
  Problem p = stiff_block({0, 0, -9.8}, 3 * kDx + 0.03, {0, 0, -2});
  const Outcome bounce = simulate(p, {6, 0.01, 50}, rigid_options());
  REQUIRE(bounce.result.status == Status::stable);
  CHECK(bounce.result.impacts.windows == 1);
  CHECK(bounce.result.rigid_bodies[0].restitution > 0.6);
  CHECK(bounce.result.rigid_bodies[0].restitution < 0.9);
  CHECK(mean(bounce.state.v).z > 0.5);

  p = stiff_block({0, 0, -9.8}, 3 * kDx, {0, 0, 0});
  const Outcome rest = simulate(p, {11, 0.02, 100}, rigid_options());
  REQUIRE(rest.result.status == Status::stable);
  CHECK(rest.result.impacts.windows == 0);
  CHECK(norm(mean(rest.state.x) - mean(p.particles.position)) < 0.5 * kDx);
  CHECK(norm(mean(rest.state.v)) < 1e-3);
}

TEST_CASE("a rigid block that slides over a rough floor is slowed by Coulomb friction, and a sticky one holds it") {
  for (const auto mode : {Collider::Mode::separate, Collider::Mode::sticky}) {
    Problem p = stiff_block({0, 0, -9.8}, 10 * kDx, {0.15, 0, 0});
    p.domain.colliders.push_back(floor_at(10 * kDx, mode, 0.3));
    Options o = rigid_options();
    o.impact_budget = -1;
    const Outcome out = simulate(p, {3, 0.02, 100}, o);
    REQUIRE(out.result.status == Status::stable);
    const double speed = mean(out.state.v).x;
    if (mode == Collider::Mode::sticky) {
      CHECK(std::fabs(speed) < 1e-3);
    } else {
      // It presses with its weight once it has settled.
      CHECK(speed == doctest::Approx(0.15 - 0.3 * 9.8 * 0.04).epsilon(0.25));
    }
  }
}

TEST_CASE("an action that moves a rigid row moves it exactly, and pushes what is in its way") {
  Problem p = stiff_block({0, 0, 0}, 0.8, {0, 0, 0});
  p.materials.push_back(kSoft);
  p.object = {0, 1};
  add_block(p, {1.08, 0.85, 0.86}, {1.32, 1.05, 1.1}, 1, kDx);
  p.schedule.actions.push_back(Translation{{0}, {1, 0, 0.5}, 0, 0.1});
  const Outcome out = simulate(p, {6, 0.02, 100}, rigid_options());
  REQUIRE(out.result.status == Status::stable);
  State stiff = out.state;
  stiff.x.resize(6 * 6 * 6 * 8);
  for (size_t i = 0; i < stiff.x.size(); ++i) {
    CHECK(norm(stiff.x[i] - p.particles.position[i] - Vec3d{0.1, 0, 0.05}) < 1e-10);
  }
  CHECK(out.state.v.back().x > 0.05);
  CHECK(out.result.balances.back().control_work > 0);

  p.schedule.actions = {Impulse{{0}, {0.7, 0, 0}, 0, 8e-4, 2e-4}};
  const Outcome kicked = simulate(p, {2, 0.02, 100}, rigid_options());
  const Vec3d whole = kicked.result.balances.back().momentum;
  CHECK(whole.x == doctest::Approx(0.7 * 2000 * 6 * 6 * 6 * kDx * kDx * kDx).epsilon(1e-9));
}

TEST_CASE("runs with rigid rows do not depend on the threads, byte for byte, windows included") {
  Problem p = stiff_block({0, 0, -9.8}, 3 * kDx + 0.03, {0.2, 0, -2});
  p.materials.push_back(kSoft);
  p.object = {0, 1};
  add_block(p, {0.78, 0.78, 3 * kDx + 0.3}, {1.1, 1.1, 3 * kDx + 0.54}, 1, kDx);
  for (const Precision precision : {Precision::single, Precision::full}) {
    const Outcome one = simulate(p, {4, 0.01, 50}, rigid_options(precision, 1));
    const Outcome three = simulate(p, {4, 0.01, 50}, rigid_options(precision, 3));
    REQUIRE(one.result.status == Status::stable);
    CHECK(one.result.impacts.windows > 0);
    CHECK(std::memcmp(one.state.x.data(), three.state.x.data(), one.state.x.size() * sizeof(Vec3d)) == 0);
    CHECK(std::memcmp(one.state.F.data(), three.state.F.data(), one.state.F.size() * sizeof(Mat3d)) == 0);
  }
}

TEST_CASE("the energy budget has a term of its own for rigid rows, and closes as it does without them") {
  Problem p = stiff_block({0, 0, -9.8}, 0.66, {0, 0, -1});
  p.materials.push_back(kSoft);
  p.object = {0, 1};
  add_block(p, {0.78, 0.78, 3 * kDx}, {1.1, 1.1, 0.6}, 1, kDx);
  Options o = rigid_options();
  o.measure_steps = true;
  const Outcome out = simulate(p, {6, 0.01, 50}, o);
  REQUIRE(out.result.status == Status::stable);
  const Balance& last = out.result.balances.back();
  CHECK(last.budget.rigid < 0);
  CHECK(std::fabs(last.budget.residual()) < 0.02 * out.result.balances.front().kinetic);
  double lowest = out.result.balances.front().energy();
  for (const Balance& b : out.result.balances) {
    CHECK(b.energy() < lowest + 1e-5 * out.result.balances.front().kinetic);
    lowest = std::min(lowest, b.energy());
  }
}

TEST_CASE("steps by cfl are chosen by what deforms, and impacts have their windows") {
  Problem p = stiff_block({0, 0, -9.8}, 3 * kDx + 0.03, {0, 0, -2});
  Timing t{6, 0.01, 50};
  t.rule = StepRule::cfl;
  const Outcome out = simulate(p, t, rigid_options());
  REQUIRE(out.result.status == Status::stable);
  CHECK(out.result.impacts.windows == 1);
  CHECK(out.result.steps < 2000);
  CHECK(mean(out.state.v).z > 0.5);
}

TEST_CASE("a rigid support that is projected at frames goes on from where the projection put it") {
  for (const auto mode : {StructureProjection::Mode::literal, StructureProjection::Mode::rigid}) {
    Problem p = stiff_block({0, 0, -9.8}, 1.2, {0.5, 0, 0});
    p.schedule.projections.push_back({0, 0.85, mode});
    const Outcome out = simulate(p, {6, 0.02, 100}, rigid_options());
    REQUIRE(out.result.status == Status::stable);
    CHECK((mean(out.state.x) - mean(p.particles.position)).x == doctest::Approx(0.05).epsilon(1e-6));
    CHECK(largest_change_of_shape(p, out.state) < 1e-9);
  }
}
