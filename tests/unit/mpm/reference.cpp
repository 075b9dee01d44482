// The back end's fused pass against the substep in plain loops.
#include "mpm/reference.h"

#include <doctest/doctest.h>

#include <string>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

constexpr int kSteps = 20;
constexpr double kStep = 4e-4;  // s

// The last of kSteps substeps by the reference.
State by_reference(const Problem& p) {
  const ActionPlan actions(p.schedule.actions, p.particles);
  const StepperSetup setup = setup_of(p, actions);
  State state;
  state.x = p.particles.position;
  state.v = p.particles.velocity;
  state.F.assign(state.size(), identity<double>());
  state.C.assign(state.size(), diagonal(0.0, 0.0, 0.0));
  state.total_F = state.F;
  for (const int row : setup.row) state.strength.push_back(setup.parameters[row].yield);
  std::vector<Control> controls;
  for (int step = 0; step < kSteps; ++step) {
    actions.controls(step * kStep, kStep, controls);
    reference::substep(setup, controls, kStep, state);
  }
  return state;
}

State by_stepper(const Problem& p, int frames) {
  Options o = options();
  o.track_total_F = true;
  const int substeps = kSteps / frames;
  return simulate(p, {frames + 1, substeps * kStep, substeps}, o).state;
}

double largest(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, norm(a[i] - b[i]));
  return most;
}
double largest(const std::vector<Mat3d>& a, const std::vector<Mat3d>& b) {
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::sqrt(squared_norm(a[i] - b[i])));
  return most;
}

// Places are of 1 m, speeds of some m/s, strains of some tenths. A rounding of a stress changes a velocity by dt/dx
// times the speed of sound squared, about a rounding of it, in each of twenty substeps; contact and yield amplify that
// little. Gradients of velocities are differences over a cell.
constexpr double kRoundings = 100 * kEpsilon<double>;

void check_same(const Problem& p, int frames = 1) {
  const State a = by_reference(p), b = by_stepper(p, frames);
  REQUIRE(a.size() == b.size());
  CHECK(largest(a.x, b.x) < kRoundings);       // m
  CHECK(largest(a.v, b.v) < 10 * kRoundings);  // m/s
  CHECK(largest(a.F, b.F) < 10 * kRoundings);
  CHECK(largest(a.total_F, b.total_F) < 10 * kRoundings);
  CHECK(largest(a.C, b.C) < 10 * kRoundings / p.domain.dx());  // 1/s
  for (size_t i = 0; i < a.size(); ++i) REQUIRE(std::fabs(a.strength[i] - b.strength[i]) < 1e-10 * a.strength[i]);
}

// A block that falls onto a rough floor in a corner of the domain, with everything else that acts on nodes.
Problem falling_block(const Material& material) {
  Problem p = scene(material, 16, {0.5, 0, -9.8});
  const double dx = p.domain.dx();
  p.domain.colliders.push_back(floor_at(4 * dx, Collider::Mode::separate, 0.3));
  Collider ball;
  ball.type = Collider::Type::sphere;
  ball.mode = Collider::Mode::slip;
  ball.center = {7 * dx, 6 * dx, 6 * dx};
  ball.radius = 0.8 * dx;
  p.domain.colliders.push_back(ball);
  add_block(p, {3.2 * dx, 4 * dx, 4.1 * dx}, {7.2 * dx, 7 * dx, 7.1 * dx}, 0, dx, 0.3, {-2, 0.4, -3});
  return p;
}

}  // namespace

TEST_CASE("mpm reference: the fused pass does the same as the phases in plain loops, for every branch") {
  for (int b = 0; b < kBranchCount; ++b) {
    const Branch branch = static_cast<Branch>(b);
    Problem p = falling_block({branch, branch == Branch::metal ? 2e5 : 5e4, 0.3, 1000});
    p.constants.plasticine_softening = 1e4;
    INFO(std::string(branch_name(branch)));
    check_same(p);
    check_same(p, kSteps);  // frames in between are observations
  }
}

TEST_CASE("mpm reference: rows of several branches in one register, under actions of every kind") {
  Problem p = falling_block({Branch::jelly, 5e4, 0.3, 1000});
  p.materials = {{Branch::jelly, 5e4, 0.3, 1000}, {Branch::metal, 2e5, 0.3, 1200},
                 {Branch::sand, 5e4, 0.3, 1600},  {Branch::foam, 4e4, 0.3, 300},
                 {Branch::snow, 5e4, 0.2, 400},   {Branch::plasticine, 1e5, 0.3, 2000}};
  for (size_t i = 0; i < p.particles.size(); ++i) p.particles.row[i] = static_cast<int>(i % 6);
  const double end = kSteps * kStep;
  SUBCASE("none") {}
  SUBCASE("enforced") {
    p.schedule.actions.push_back(TopPress{{1, 2, 5}, {0.2, 0, -2}, {0, 0, 1}, 0.3, 0, end});
  }
  SUBCASE("blended, then free") {
    Torque torque;
    torque.rows = {0, 3, 4};
    torque.rate = 8;
    torque.end = 0.6 * end;
    p.schedule.actions.push_back(torque);
    p.schedule.actions.push_back(Impulse{{2}, {0, 1, 0}, 0.2 * end, 8e-4, kStep});
  }
  SUBCASE("enforced along an axis") {
    VerticalCompress compress;
    compress.rows = {0, 1, 2, 3, 4, 5};
    compress.ratio = 0.95;
    compress.end = end;
    p.schedule.actions.push_back(compress);
  }
  SUBCASE("with position increments") {
    SideCompress side;
    side.rows = {0, 1, 2, 3, 4, 5};
    side.ratio = 0.9;
    side.position = 0.4;
    side.end = end;
    p.schedule.actions.push_back(side);
    RadialSpread spread;
    spread.rows = {3};
    spread.end = end;
    p.schedule.actions.push_back(spread);
  }
  check_same(p);
}

// Two blocks in two bodies that strike each other over a third, and a fourth that shares cells with the third.
TEST_CASE("mpm reference: bodies with fields of their own, several of them in one block") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 16, {0.5, 0, -9.8});
  const double dx = p.domain.dx();
  p.materials.push_back({Branch::metal, 2e5, 0.3, 1500});
  p.materials.push_back({Branch::plasticine, 1e5, 0.3, 2000});
  p.materials.push_back({Branch::jelly, 5e4, 0.3, 700});
  p.domain.colliders.push_back(floor_at(4 * dx, Collider::Mode::separate, 0.3));
  add_block(p, {4.2 * dx, 5 * dx, 6.1 * dx}, {6.6 * dx, 9 * dx, 9.1 * dx}, 0, dx, 0.3, {2, 0.4, -1});
  add_block(p, {7.2 * dx, 5.5 * dx, 6.6 * dx}, {9.9 * dx, 8.2 * dx, 9.1 * dx}, 1, dx, 0.3, {-2, 0, -1});
  add_block(p, {4 * dx, 5 * dx, 4 * dx}, {10 * dx, 9 * dx, 5.9 * dx}, 2, dx, 0.3, {0, 0, 0});
  add_block(p, {5 * dx, 6 * dx, 5.5 * dx}, {6 * dx, 7 * dx, 7 * dx}, 3, dx, 0.3, {0, 0, 1});
  SUBCASE("two fields") {
    p.contact.body = {0, 1, 1, 0};
  }
  SUBCASE("four fields") {
    p.contact.body = {3, 1, 0, 2};
  }
  SUBCASE("one field") {
    p.contact.body = {0, 0, 0, 0};
  }
  p.contact.friction = 0.4;
  check_same(p);
  check_same(p, 4);
}

TEST_CASE("mpm reference: each phase does what its equation says on one particle") {
  StepperSetup setup;
  setup.domain.n = 16;
  setup.domain.gravity = {0, 0, -10};
  setup.branches = {Branch::jelly};
  setup.parameters = {derive_parameters({Branch::jelly, 1e4, 0.3, 800}, {})};
  setup.row = {0};
  setup.volume = {2e-3};
  setup.control_group = {0};
  const double dx = setup.domain.dx();
  State state;
  state.x = {{8.1 * dx, 7.7 * dx, 8.4 * dx}};
  state.v = {{1, -2, 3}};
  state.F = {identity<double>()};
  state.C = {{{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}}};
  state.strength = {1};
  const State before = state;
  reference::Grid grid = reference::p2g(setup, state, 1e-3);
  double mass = 0;
  Vec3d momentum = {0, 0, 0};
  for (size_t a = 0; a < grid.mass.size(); ++a) {
    mass += grid.mass[a];
    momentum = momentum + grid.momentum[a];
  }
  CHECK(mass == doctest::Approx(1.6));
  CHECK(norm(momentum - 1.6 * before.v[0]) < 1e-12);
  reference::grid_update(setup.domain, 1e-3, grid);
  reference::g2p(setup, {grid}, state);
  // An affine field comes back as it was (Jiang et al. 2015), and falls.
  CHECK(norm(state.v[0] - before.v[0] - Vec3d{0, 0, -1e-2}) < 1e-12);
  CHECK(std::sqrt(squared_norm(state.C[0] - before.C[0])) < 1e-10);
}

TEST_CASE("mpm reference: particles with a modulus, a Poisson ratio and a density of their own, for every branch") {
  for (int b = 0; b < kBranchCount; ++b) {
    const Branch branch = static_cast<Branch>(b);
    Problem p = falling_block({branch, 5e4, 0.3, 1000});
    INFO(std::string(branch_name(branch)));
    for (size_t i = 0; i < p.particles.size(); ++i)
      p.particles.material.push_back(
          {branch, 3e4 + 4e4 * (i % 7) / 7.0, 0.2 + 0.2 * (i % 3) / 3.0, 800 + 50.0 * (i % 5)});
    check_same(p);
  }
}
