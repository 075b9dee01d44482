// Bodies with velocity fields of their own: at one node, and in a run.
#include "mpm/body_contact.h"

#include <doctest/doctest.h>

#include <random>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

double energy(const std::vector<BodyAtNode>& bodies) {
  double sum = 0;
  for (const BodyAtNode& b : bodies) sum += 0.5 * b.mass * dot(b.u, b.u);
  return sum;
}
Vec3d momentum(const std::vector<BodyAtNode>& bodies) {
  Vec3d sum{0, 0, 0};
  for (const BodyAtNode& b : bodies) sum = sum + b.mass * b.u;
  return sum;
}

}  // namespace

TEST_CASE("mpm bodies: at a node, what approaches is stopped, what parts goes on, friction is Coulomb's") {
  // a below b: the mass of a grows downwards, that of b upwards.
  const auto pair = [](const Vec3d& ua, const Vec3d& ub) {
    return std::vector<BodyAtNode>{{2, {0, 0, -1}, ua}, {1, {0, 0, 3}, ub}};
  };
  std::vector<BodyAtNode> bodies = pair({0, 0, 1}, {0, 0, -2});
  meet(bodies.data(), 2, 0);
  CHECK(bodies[0].u.z == doctest::Approx(0));  // both have the common velocity
  CHECK(bodies[1].u.z == doctest::Approx(0));

  bodies = pair({0, 0, -1}, {0, 0, 2});
  meet(bodies.data(), 2, 0.5);
  CHECK(bodies[0].u.z == -1);
  CHECK(bodies[1].u.z == 2);

  bodies = pair({3, 0, 0}, {0, 0, -1});  // slides at 3 m/s, pressed by 1 m/s
  meet(bodies.data(), 2, 0.5);
  CHECK(bodies[0].u.x - bodies[1].u.x == doctest::Approx(3 - 0.5));
  CHECK(bodies[0].u.z == doctest::Approx(bodies[1].u.z));

  bodies = pair({0.4, 0, 0}, {0, 0, -1});  // too slow to slide
  meet(bodies.data(), 2, 0.5);
  CHECK(bodies[0].u.x == doctest::Approx(bodies[1].u.x));
}

TEST_CASE("mpm bodies: momentum is kept and energy never grows, of two to eight bodies") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<BodyAtNode> bodies(2 + trial % 7);
    for (BodyAtNode& b : bodies) {
      b.mass = std::pow(10.0, 4 * number(random));
      for (int a = 0; a < 3; ++a) b.mass_per_dx[a] = trial % 5 == 0 ? 0 : number(random), b.u[a] = 3 * number(random);
    }
    const double before = energy(bodies);
    const Vec3d p = momentum(bodies);
    meet(bodies.data(), static_cast<int>(bodies.size()), trial % 3 * 0.4);
    double whole = 0;
    for (const BodyAtNode& b : bodies) whole += b.mass;
    CHECK(energy(bodies) <= before * (1 + 1e-12));
    CHECK(norm(momentum(bodies) - p) < 1e-12 * whole);
  }
}

// A light ball on a slab is thrown up: it leaves, and the slab stays; with one field for both it takes the slab along.
TEST_CASE("mpm bodies: what is thrown off a body does not take it along, and what falls on it is carried") {
  Problem p = scene({Branch::jelly, 2e5, 0.3, 1000}, 24, {0, 0, -9.8});
  p.materials.push_back({Branch::jelly, 2e5, 0.3, 1000});
  const double dx = p.domain.dx();
  p.domain.colliders.push_back(floor_at(4 * dx));
  add_block(p, {6 * dx, 6 * dx, 4 * dx}, {18 * dx, 18 * dx, 7 * dx}, 0, dx);
  const size_t slab = p.particles.size();
  const auto heights = [&](const State& state) {
    return std::pair(mean({state.x.begin(), state.x.begin() + slab}).z,
                     mean({state.x.begin() + slab, state.x.end()}).z);
  };
  State start;
  start.x = p.particles.position;

  SUBCASE("thrown") {
    add_block(p, {10 * dx, 10 * dx, 7 * dx}, {14 * dx, 14 * dx, 10 * dx}, 1, dx, 0.2, {0, 0, 3});
    start.x = p.particles.position;
    const Timing timing{2, 0.1, 500};
    const auto [glued_slab, glued_ball] = heights(simulate(p, timing).state);
    p.contact = {{0, 1}, 0.4};
    const auto [slab_z, ball_z] = heights(simulate(p, timing).state);
    const auto [slab_0, ball_0] = heights(start);
    CHECK(ball_z - ball_0 == doctest::Approx(3 * 0.1 - 0.5 * 9.8 * 0.01).epsilon(0.01));  // free flight
    CHECK(std::fabs(slab_z - slab_0) < 0.05 * dx);                                        // sags a little
    CHECK(glued_slab > slab_z + 0.03 * dx);
    CHECK(glued_ball < ball_z - dx);
  }
  SUBCASE("falling") {
    add_block(p, {10 * dx, 10 * dx, 9 * dx}, {14 * dx, 14 * dx, 12 * dx}, 1, dx, 0.2, {0, 0, -1});
    start.x = p.particles.position;
    p.contact = {{0, 1}, 0.4};
    Options o = options();
    o.measure_steps = true;
    const Outcome out = simulate(p, {6, 0.1, 500}, o), fine = simulate(p, {6, 0.1, 2000}, o);
    REQUIRE(out.result.status == Status::stable);
    // It lies on the slab: fields meet a cell before surfaces do.
    const auto [slab_z, ball_z] = heights(out.state);
    CHECK(ball_z > 8 * dx);
    CHECK(ball_z < 10 * dx);
    // Impacts lose energy, as measured; what no term explains is the error of the steps, and goes with them.
    CHECK(out.result.balances.back().budget.contact < 0);
    CHECK(out.result.balances.back().budget.change < 0);
    CHECK(energy_residual(fine.result).joules < 0.5 * energy_residual(out.result).joules);
  }
}

TEST_CASE("mpm bodies: a run does not depend on threads, and rows of one body are not parted") {
  Problem p = scene({Branch::jelly, 2e5, 0.3, 1000}, 24, {0, 0, -9.8});
  for (int i = 0; i < 3; ++i) p.materials.push_back({Branch::jelly, 2e5, 0.3, 1000.0 + i});
  const double dx = p.domain.dx();
  p.domain.colliders.push_back(floor_at(4 * dx, Collider::Mode::separate, 0.5));
  for (int i = 0; i < 4; ++i) {
    const double z = (4 + 3 * i) * dx, shift = 0.3 * i * dx;
    add_block(p, {7 * dx + shift, 7 * dx, z}, {15 * dx + shift, 16 * dx, z + 3 * dx}, i, dx, 0.3, {0.5 * i, 0, 0});
  }
  p.contact = {{0, 1, 1, 2}, 0.3};
  for (const Precision precision : {Precision::single, Precision::full}) {
    const Timing timing{3, 0.04, 100};
    const State one = simulate(p, timing, options(precision, 1)).state,
                four = simulate(p, timing, options(precision, 4)).state;
    for (size_t i = 0; i < one.size(); ++i) {
      for (int a = 0; a < 3; ++a) REQUIRE(one.x[i][a] == four.x[i][a]);
    }
  }
  Problem together = p;
  together.contact = {{0, 0, 0, 0}, 0.3};
  Problem plain = p;
  plain.contact = {};
  const State a = simulate(together, {2, 0.04, 100}).state, b = simulate(plain, {2, 0.04, 100}).state;
  for (size_t i = 0; i < a.size(); ++i) {
    for (int k = 0; k < 3; ++k) REQUIRE(a.x[i][k] == b.x[i][k]);
  }
}
