// A rigid body by itself: rotation, fit, free motion; and the algebra below it.
#include "mpm/rigid/rigid_body.h"

#include <doctest/doctest.h>

#include "mpm/rigid/rigid_solve.h"

using namespace physmas;
using namespace physmas::mpm;

namespace {

double distance(const Mat3d& a, const Mat3d& b) {
  return std::sqrt(squared_norm(a - b));
}

RigidBodyRest brick() {
  RigidBodyRest rest;
  rest.mass = 3;
  rest.inertia = diagonal(0.2, 0.5, 0.6);
  return rest;
}

}  // namespace

TEST_CASE("rotation_by is a rotation about its vector by its length, series included") {
  for (const double angle : {0.0, 1e-9, 9.9e-5, 1.01e-4, 0.3, 3.0}) {
    const Vec3d axis = {2.0 / 3, -1.0 / 3, 2.0 / 3};
    const Mat3d R = rotation_by(angle * axis);
    CHECK(distance(times_transposed(R, R), identity<double>()) < 1e-14);
    CHECK(determinant(R) == doctest::Approx(1).epsilon(1e-14));
    CHECK(norm(R * axis - axis) < 1e-15);
    CHECK(trace(R) == doctest::Approx(1 + 2 * std::cos(angle)).epsilon(1e-14));
  }
}

TEST_CASE("a body that spins freely keeps its angular momentum, and its energy to the step's second order") {
  const RigidBodyRest rest = brick();
  const auto energy_change = [&](double dt) {
    RigidBody body;
    body.rotation = rotation_by({0.3, -0.2, 0.5});
    body.set_motion(rest, {{1, 2, 3}, {0.4, 8, 0.3}});
    const Vec3d L = body.angular_momentum;
    const double before = 0.5 * dot(body.motion.spin, L);
    double most = 0;
    for (double t = 0; t < 1; t += dt) {
      body.move(rest, dt);
      most = std::max(most, std::fabs(0.5 * dot(body.motion.spin, L) / before - 1));
    }
    CHECK(norm(body.angular_momentum - L) == 0);
    CHECK(norm(body.inertia(rest) * body.motion.spin - L) < 1e-12 * norm(L));
    CHECK(body.center.y == doctest::Approx(2).epsilon(2 * dt));
    return most;
  };
  const double coarse = energy_change(4e-3), fine = energy_change(2e-3);
  CHECK(coarse < 1e-3);
  CHECK(fine < coarse / 3);
}

TEST_CASE("fit finds the motion and the place of particles that move rigidly") {
  const double dx = 0.1;
  RigidBodyRest rest;
  std::vector<Vec3d> offset;
  std::vector<double> mass;
  const std::vector<Vec3d> x = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 1, 1}};
  Vec3d first{0, 0, 0};
  for (size_t i = 0; i < x.size(); ++i) {
    mass.push_back(1 + 0.5 * static_cast<double>(i));
    rest.particles.push_back(static_cast<int>(i));
    rest.mass += mass[i];
    first = first + mass[i] * x[i];
  }
  rest.center = (1 / rest.mass) * first;
  rest.inertia = (0.5 * rest.mass * dx * dx) * identity<double>();
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3d d = x[i] - rest.center;
    offset.push_back(d);
    rest.inertia = rest.inertia + (mass[i] * dot(d, d)) * identity<double>();
    for (int a = 0; a < 3; ++a) rest.inertia[a] = rest.inertia[a] - (mass[i] * d[a]) * d;
  }
  const Mat3d R = rotation_by({0.5, 1.1, -0.3});
  const Twist twist = {{0.3, -1, 2}, {4, -3, 1}};
  State state;
  for (const Vec3d& d : offset) {
    state.x.push_back(Vec3d{5, 6, 7} + R * d);
    state.v.push_back(twist.at(R * d));
    state.C.push_back(cross_matrix(twist.spin));
    state.F.push_back(R);
  }
  RigidBody body;
  body.fit(rest, offset, state, mass, dx);
  CHECK(norm(body.center - Vec3d{5, 6, 7}) < 1e-13);
  CHECK(distance(body.rotation, R) < 1e-7);  // a whiff of the rotation before holds what has no extent
  CHECK(norm(body.motion.velocity - twist.velocity) < 1e-13);
  CHECK(norm(body.motion.spin - twist.spin) < 1e-6);
}

TEST_CASE("moments of nodes give back the twist that they move with, from any origin") {
  const Twist twist = {{1, -2, 0.5}, {3, 0.2, -4}};
  NodeMoments about_corner, about_center;
  const Vec3d corner = {0.7, -0.3, 2};  // from the centre
  for (int i = 0; i < 27; ++i) {
    const Vec3d x = {0.1 * (i / 9), 0.2 * (i / 3 % 3), 0.3 * (i % 3)};
    NodeMoments node;
    node.w = 1 + i % 5;
    node.wu = node.w * twist.at(corner + x);
    about_corner.add(node, x);
  }
  about_center.add(about_corner, corner);
  const Twist found = RigidSolver::fit(about_center);
  CHECK(norm(found.velocity - twist.velocity) < 1e-11);
  CHECK(norm(found.spin - twist.spin) < 1e-11);
}

TEST_CASE("dense factors solve what needs a row exchange, and leave alone what nothing holds") {
  const double A[9] = {0, 2, 0, 3, 1, 0, 0, 0, 0};
  DenseFactors factors;
  factors.factor(3, A);
  double b[3] = {4, 5, 0};
  factors.solve(b);
  CHECK(b[0] == doctest::Approx(1));
  CHECK(b[1] == doctest::Approx(2));
  CHECK(b[2] == 0);
}
