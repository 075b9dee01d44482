// Contact of rigid bodies at nodes.
#include "mpm/rigid/rigid_solve.h"

#include <doctest/doctest.h>

using namespace physmas;
using namespace physmas::mpm;

namespace {

// Four nodes of a plate about its centre, in an obstacle.
RigidSystem plate(const NodeObstacle& obstacle, const Vec3d& u, double lock) {
  RigidSystem system;
  system.free.resize(1);
  system.prescribed = {0};
  for (int i = 0; i < 4; ++i) {
    HeldNode node;
    node.body = 0;
    node.from_center = {i % 2 ? 0.1 : -0.1, i / 2 ? 0.1 : -0.1, -0.02};
    node.mass = 2, node.lock = lock, node.u = u;
    node.obstacles = {&obstacle, 1};
    system.held.push_back(node);
  }
  return system;
}

}  // namespace

TEST_CASE("an obstacle's effect on a node and its slope agree with differences, whatever the mode") {
  for (const auto mode : {Collider::Mode::sticky, Collider::Mode::slip, Collider::Mode::separate}) {
    for (const double friction : {0.0, 0.4}) {
      const Vec3d n = {0.36, 0.48, 0.8};
      const NodeObstacle obstacle = {n, mode, friction};
      for (const Vec3d& u : {Vec3d{1, 0.2, -0.5}, Vec3d{0.3, 2, 1}, Vec3d{-1, -1, -3}}) {
        Mat3d slope, unused;
        apply_obstacle(obstacle, u, slope);
        for (int b = 0; b < 3; ++b) {
          Vec3d step = {0, 0, 0};
          step[b] = 1e-6;
          const Vec3d d = apply_obstacle(obstacle, u + step, unused) - apply_obstacle(obstacle, u - step, unused);
          for (int a = 0; a < 3; ++a) CHECK(std::fabs(d[a] / 2e-6 - slope[a][b]) < 1e-8);
        }
      }
    }
  }
}

TEST_CASE("a plate that falls on a floor is stopped by the lock's compliance, and slides on without friction") {
  const NodeObstacle floor = {{0, 0, 1}, Collider::Mode::separate, 0};
  const double lock = 1000;
  const RigidSystem system = plate(floor, {1, 0, -3}, lock);
  RigidSolver solver;
  const Twist free = solver.solve(system, {Twist()}, false)[0], met = solver.solve(system, {Twist()}, true)[0];
  CHECK(norm(free.velocity - Vec3d{1, 0, -3}) < 1e-12);
  CHECK(norm(free.spin) < 1e-12);
  CHECK(met.velocity.x == doctest::Approx(1));
  // All mass is at the floor: nothing is left that could press.
  CHECK(std::fabs(met.velocity.z) < 1e-9);
  CHECK(norm(met.spin) < 1e-9);
}

TEST_CASE("Coulomb friction on a plate's nodes takes its share of the tangential speed, and a sticky floor all") {
  const NodeObstacle rough = {{0, 0, 1}, Collider::Mode::separate, 0.25};
  RigidSystem system = plate(rough, {2, 0, -1}, 1e6);
  // What is above the floor presses it down.
  NodeMoments above;
  above.w = 8;
  above.wu = 8.0 * Vec3d{2, 0, -1};
  system.free[0].add(above, {0, 0, 0.02});
  RigidSolver solver;
  const Twist met = solver.solve(system, {Twist()}, true)[0];
  // 16 kg with 16 kg m/s downwards: friction takes a quarter of that impulse from 32 kg m/s.
  CHECK(met.velocity.x == doctest::Approx((32 - 4) / 16.0).epsilon(0.02));
  const NodeObstacle sticky = {{0, 0, 1}, Collider::Mode::sticky, 0};
  CHECK(norm(solver.solve(plate(sticky, {2, 0, -1}, 1e6), {Twist()}, true)[0].velocity) < 1e-9);
}

TEST_CASE("two bodies that approach at a node share momentum, two that part do not") {
  RigidSystem system;
  system.free.resize(2);
  system.prescribed = {0, 0};
  for (int b = 0; b < 2; ++b) {
    NodeMoments node;
    node.w = b == 0 ? 1 : 3;
    node.wu = node.w * Vec3d{b == 0 ? 2.0 : -2.0, 0, 0};
    for (const Vec3d& x : {Vec3d{0.1, 0, 0}, Vec3d{-0.1, 0, 0}, Vec3d{0, 0.1, 0}, Vec3d{0, -0.1, 0}, Vec3d{0, 0, 0.1},
                           Vec3d{0, 0, -0.1}}) {
      NodeMoments at;
      at.add(node, {0, 0, 0});
      system.free[b].add(at, x);
    }
  }
  BodyPair pair;
  pair.body[0] = 0, pair.body[1] = 1;
  pair.from_center[0] = {0.2, 0, 0}, pair.from_center[1] = {-0.2, 0, 0};
  pair.normal = {1, 0, 0};
  pair.lock = 1e8;
  system.pairs = {pair};
  RigidSolver solver;
  std::vector<Twist> met = solver.solve(system, {Twist(), Twist()}, true);
  CHECK(6 * met[0].velocity.x + 18 * met[1].velocity.x == doctest::Approx(12 - 36).epsilon(1e-12));
  const auto closing = [&] { return met[0].at(pair.from_center[0]).x - met[1].at(pair.from_center[1]).x; };
  CHECK(std::fabs(closing()) < 1e-6);
  const RigidImpact impact = solver.impact(system, {{{2, 0, 0}, {0, 0, 0}}, {{-2, 0, 0}, {0, 0, 0}}}, met);
  CHECK(impact.approach == doctest::Approx(4));
  CHECK(impact.share == doctest::Approx(1).epsilon(1e-5));
  for (NodeMoments& m : system.free) {
    m.wu = -m.wu;
    for (Vec3d& row : m.wxu.row) row = -row;
  }
  met = solver.solve(system, {Twist(), Twist()}, true);
  CHECK(met[0].velocity.x == doctest::Approx(-2));
  CHECK(met[1].velocity.x == doctest::Approx(2));
}
