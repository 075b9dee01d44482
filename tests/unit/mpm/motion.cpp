// Motion without and with contact: free fall, conservation, energy, walls, colliders, faults, threads.
#include <doctest/doctest.h>

#include <cstring>

#include "base/error.h"
#include "unit/mpm/scenes.h"

using namespace mpm_test;

TEST_CASE("mpm free fall: every particle follows the symplectic Euler trajectory") {
  for (const Precision precision : {Precision::full, Precision::single}) {
    Problem p = scene({Branch::jelly, 1e4, 0.3, 1000}, 32, {0, 0, -9.8});
    add_block(p, {0.8, 0.8, 1.2}, {1.2, 1.2, 1.6}, 0, p.domain.dx());
    const Timing t{2, 0.1, 200};
    const Outcome out = simulate(p, t, options(precision));
    const double dt = 0.1 / 200, n = 200;
    double error = 0, speed_error = 0, error_continuous = 0;
    for (size_t i = 0; i < p.particles.size(); ++i) {
      const double drop = -9.8 * dt * dt * n * (n + 1) / 2;
      error = std::max(error, std::fabs(out.state.x[i].z - p.particles.position[i].z - drop));
      error_continuous =
          std::max(error_continuous, std::fabs(out.state.x[i].z - p.particles.position[i].z + 0.5 * 9.8 * 0.01));
      speed_error = std::max(speed_error, std::fabs(out.state.v[i].z + 9.8 * 0.1));
    }
    // Uniform motion is exact in APIC; what is left is rounding: of the weights' sum (1 ulp of the speed a step), and
    // of positions that are held relative to their block, in cells (ulp of 4 cells a step, random sign).
    const bool full = precision == Precision::full;
    CHECK(error < (full ? 1e-13 : 2e-6));
    CHECK(speed_error < (full ? 1e-13 : 2e-5));
    CHECK(error_continuous < 0.5 * 9.8 * 0.1 * dt * 1.05);  // g t dt / 2, first order in dt
  }
}

TEST_CASE("mpm conservation: mass, momentum and angular momentum of a free spinning, oscillating body") {
  for (const Precision precision : {Precision::full, Precision::single}) {
    Problem p = scene({Branch::jelly, 2e4, 0.3, 1000});
    add_block(p, {0.75, 0.8, 0.85}, {1.2, 1.2, 1.2}, 0, p.domain.dx());
    for (size_t i = 0; i < p.particles.size(); ++i) {
      const Vec3d q = p.particles.position[i] - Vec3d{1, 1, 1};
      p.particles.velocity[i] = Vec3d{0.1, 0.05, -0.1} + cross(Vec3d{0.5, -1, 2}, q) + Vec3d{0.8 * q.x, -0.5 * q.y, 0};
    }
    const Outcome out = simulate(p, {3, 0.25, 500}, options(precision));
    REQUIRE(out.result.status == Status::stable);
    const Balance& first = out.result.balances.front();
    const Balance& last = out.result.balances.back();
    CHECK(last.mass == first.mass);  // no arithmetic touches it
    const double momentum = norm(last.momentum - first.momentum) / (first.mass * 0.15);
    const double spin = norm(last.angular_momentum - first.angular_momentum) / norm(first.angular_momentum);
    // A thousand steps of rounding in sums over 27 nodes; random signs give about sqrt(1000) ulp, a bias 1000 ulp.
    // In float the weights of a particle sum to 1 within an ulp: 1e-7 × 1000 at worst.
    const bool full = precision == Precision::full;
    CHECK(momentum < (full ? 1e-12 : 1e-4));
    CHECK(spin < (full ? 1e-12 : 1e-4));
  }
}

TEST_CASE("mpm energy: total energy of Jelly, Metal and Foam does not grow") {
  for (const Branch branch : {Branch::jelly, Branch::metal, Branch::foam}) {
    Problem p = scene({branch, 5e4, 0.3, 1000});
    add_block(p, {0.75, 0.75, 0.75}, {1.25, 1.25, 1.25}, 0, p.domain.dx());
    for (size_t i = 0; i < p.particles.size(); ++i) {
      const Vec3d q = p.particles.position[i] - Vec3d{1, 1, 1};
      p.particles.velocity[i] = {2 * q.x, -1 * q.y, -1 * q.z + 0.5 * q.x};
    }
    const Outcome out = simulate(p, {41, 0.01, 50});
    REQUIRE(out.result.status == Status::stable);
    double highest = 0;
    for (const Balance& b : out.result.balances) highest = std::max(highest, b.kinetic + b.elastic);
    INFO(branch_name(branch));
    // Symplectic Euler lets the energy of an oscillation swing by omega dt / 2, here below 2 %.
    CHECK(highest <= 1.02 * out.result.balances[0].kinetic);
    const Balance& last = out.result.balances.back();
    CHECK(last.kinetic + last.elastic <= 1.001 * out.result.balances[0].kinetic);
    CHECK(out.result.min_J < 1);
  }
}

TEST_CASE("mpm determinism: the same bytes for 1, 2 and 3 threads, with every branch, colliders and actions") {
  for (const Precision precision : {Precision::full, Precision::single}) {
    Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 40, {0, 0, -9.8});
    p.materials = {{Branch::jelly, 5e4, 0.3, 1000}, {Branch::metal, 1e5, 0.3, 1200},
                   {Branch::sand, 5e4, 0.3, 1600},  {Branch::foam, 4e4, 0.3, 200},
                   {Branch::snow, 5e4, 0.2, 400},   {Branch::plasticine, 1e5, 0.3, 2000}};
    for (int row = 0; row < 6; ++row) {
      const double x = 0.5 + 0.16 * row;
      // Wide enough that three threads have ranges of blocks of their own (blocks.cpp).
      add_block(p, {x, 0.55, 0.3}, {x + 0.16, 1.4, 0.55}, row, p.domain.dx());
    }
    p.domain.colliders.push_back(floor_at(0.28, Collider::Mode::separate, 0.4));
    p.schedule.actions.push_back(TopPress{{2, 5}, {0, 0, -0.5}, {0, 0, 1}, 0.2, 0.005, 0.03});
    p.schedule.actions.push_back(Impulse{{0}, {1, 0, 0}, 0.01, 8e-4, 2e-4});
    p.schedule.projections.push_back({1, 0.85});
    p.schedule.retentions.push_back({1, {0, 2}});
    const Timing t{4, 0.02, 60};
    const Outcome one = simulate(p, t, options(precision, 1));
    REQUIRE(one.result.status == Status::stable);
    for (const int threads : {2, 3}) {
      const Outcome many = simulate(p, t, options(precision, threads));
      const size_t n = p.particles.size();
      CHECK(std::memcmp(one.state.x.data(), many.state.x.data(), n * sizeof(Vec3d)) == 0);
      CHECK(std::memcmp(one.state.v.data(), many.state.v.data(), n * sizeof(Vec3d)) == 0);
      CHECK(std::memcmp(one.state.F.data(), many.state.F.data(), n * sizeof(Mat3d)) == 0);
      CHECK(one.result.balances.back().elastic == many.result.balances.back().elastic);
      CHECK(one.result.max_speed == many.result.max_speed);
    }
  }
}

TEST_CASE("mpm walls: material comes to rest on the domain wall and no particle leaves the grid") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  add_block(p, {0.8, 0.8, 0.3}, {1.1, 1.1, 0.6}, 0, p.domain.dx(), 0.2, {3, 0, -3});
  const Outcome out = simulate(p, {51, 0.04, 80});
  REQUIRE(out.result.status == Status::stable);
  CHECK(out.result.particles_at_wall > 0);
  CHECK(out.result.particles_outside == 0);
  const double dx = p.domain.dx();
  for (const Vec3d& x : out.state.x) {
    for (int axis = 0; axis < 3; ++axis) {
      // Half a cell inside the wall nodes every node of the stencil has lost its outward velocity.
      CHECK(x[axis] > 2.5 * dx);
      CHECK(x[axis] < 2 - 2.5 * dx);
    }
  }
}

TEST_CASE("mpm walls: particles that start outside are held at the edge and counted") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  add_block(p, {0.8, 0.8, 0.8}, {1.0, 1.0, 1.0}, 0, p.domain.dx());
  p.particles.position[0] = {-5, 1, 1};
  p.particles.position[1] = {1, 1, 2};
  p.particles.position[2] = {1e30, -1e30, 1};
  const Outcome out = simulate(p, {3, 0.02, 40}, options(Precision::single));
  CHECK(out.result.particles_outside == 3);
  for (const Vec3d& x : out.state.x) {
    for (int axis = 0; axis < 3; ++axis) CHECK((x[axis] > 0 && x[axis] < 2));
  }
}

TEST_CASE("mpm walls: a particle within the edge of an odd grid is not counted, nor are the lanes beside it") {
  // The last block of 31 cells ends in the middle of where empty lanes would rest.
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 31);
  const double dx = p.domain.dx();
  p.particles.position = {{28.9 * dx, 1, 1}};
  p.particles.volume = {dx * dx * dx / 8};
  p.particles.row = {0};
  CHECK(simulate(p, {2, 0.01, 10}).result.particles_outside == 0);
  CHECK(simulate(p, {2, 0.01, 10}, options(Precision::single)).result.particles_outside == 0);
}

TEST_CASE("mpm faults: a modulus of 3e11 at the paper's base substep diverges cleanly, whatever the branch") {
  for (const Precision precision : {Precision::full, Precision::single}) {
    for (int b = 0; b < kBranchCount; ++b) {
      Problem p = scene({static_cast<Branch>(b), 3e11, 0.3, 7800}, 100, {0, 0, -9.8});
      add_block(p, {0.9, 0.9, 0.12}, {1.1, 1.1, 0.32}, 0, p.domain.dx());
      p.domain.colliders.push_back(floor_at(0.1));
      const Outcome out = simulate(p, {11, 0.04, 200}, options(precision));
      INFO(kBranchNames[b]);
      CHECK(out.result.status == Status::diverged);
      CHECK(out.result.first_bad_step >= 0);
      CHECK(out.result.first_bad_step == out.result.steps - 1);
      CHECK(!out.result.reason.empty());
      CHECK(out.result.frames_done == static_cast<int>(out.result.balances.size()));
      for (const Vec3d& x : out.state.x) CHECK(std::isfinite(norm(x)));  // the last good frame
    }
  }
}

TEST_CASE("mpm faults: an initial speed above a cell per substep is found in the first substep") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000});
  add_block(p, {0.8, 0.8, 0.8}, {1.0, 1.0, 1.0}, 0, p.domain.dx(), 0.2, {1000, 0, 0});
  const Outcome out = simulate(p, {2, 0.04, 40});
  CHECK(out.result.status == Status::diverged);
  CHECK(out.result.first_bad_step == 0);
  CHECK(out.result.reason == "speed");
}

TEST_CASE("mpm faults: a diverged run names the row that bears the smallest step, and the one that was the fastest") {
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000});
  p.materials.push_back({Branch::metal, 1e12, 0.3, 1000});
  p.materials.push_back({Branch::metal, 1e14, 0.3, 1000});  // without particles
  add_block(p, {0.5, 0.8, 0.8}, {0.7, 1.0, 1.0}, 0, p.domain.dx(), 0.2, {1000, 0, 0});
  add_block(p, {1.3, 0.8, 0.8}, {1.5, 1.0, 1.0}, 1, p.domain.dx(), 0.2, {0, 0, 0});
  const Outcome fast = simulate(p, {2, 0.04, 40});
  CHECK(fast.result.status == Status::diverged);
  CHECK(fast.result.fault_row == 0);
  CHECK(fast.result.fault_speed > 900);
  CHECK(fast.result.stiffest_row == 1);
  CHECK(fast.result.stiffest_limit == rest_limit(derive_parameters(p.materials[1], {}), p.domain.dx()));
}

TEST_CASE("mpm faults: broken input is refused with exit code 3") {
  Problem good = scene({Branch::jelly, 1e4, 0.3, 1000});
  add_block(good, {0.8, 0.8, 0.8}, {0.9, 0.9, 0.9}, 0, good.domain.dx());
  const auto refused = [&](const auto& change) {
    Problem p = good;
    change(p);
    try {
      simulate(p, {2, 0.01, 10});
    } catch (const Error& e) {
      return e.code() == ExitCode::invalid_input;
    }
    return false;
  };
  CHECK(refused([](Problem& p) { p.particles.position[3].x = std::nan(""); }));
  CHECK(refused([](Problem& p) { p.particles.volume[3] = 0; }));
  CHECK(refused([](Problem& p) { p.particles.row[3] = 7; }));
  CHECK(refused([](Problem& p) { p.materials[0].nu = 0.5; }));
  CHECK(refused([](Problem& p) { p.particles.volume.pop_back(); }));
  CHECK(refused([](Problem& p) { p.domain.n = 4; }));
}

TEST_CASE("mpm extremes: no particles, one particle, coincident particles, zero frames to do") {
  Problem none = scene({Branch::jelly, 1e4, 0.3, 1000});
  CHECK(simulate(none, {3, 0.01, 10}).result.frames_done == 3);
  for (int b = 0; b < kBranchCount; ++b) {
    Problem p = scene({static_cast<Branch>(b), 1e5, 0.3, 1000}, 32, {0, 0, -9.8});
    for (int i = 0; i < 5; ++i) {
      // Four at one point, exactly on a grid node; one alone.
      p.particles.position.push_back(i < 4 ? Vec3d{1, 1, 1} : Vec3d{0.5, 0.5, 0.5});
      p.particles.volume.push_back(1e-5);
      p.particles.row.push_back(0);
    }
    const Outcome out = simulate(p, {3, 0.04, 100}, options(Precision::single));
    INFO(kBranchNames[b]);
    CHECK(out.result.status == Status::stable);
    CHECK(out.state.x[0].z == doctest::Approx(1 - 0.5 * 9.8 * 0.08 * 0.08).epsilon(1e-3));
    CHECK(simulate(p, {1, 0.04, 100}).result.steps == 0);
  }
}

TEST_CASE("mpm colliders: a dropped jelly box stays above the floor and comes to rest") {
  Problem p = scene({Branch::jelly, 3e4, 0.3, 1000}, 40, {0, 0, -9.8});
  add_block(p, {0.8, 0.8, 0.5}, {1.2, 1.2, 0.9}, 0, p.domain.dx());
  // Friction and a floor at a node plane: contact holds at nodes on or below it.
  p.domain.colliders.push_back(floor_at(0.4, Collider::Mode::separate, 0.5));
  const Outcome out = simulate(p, {76, 0.04, 80}, options(Precision::single));
  REQUIRE(out.result.status == Status::stable);
  double lowest = 2;
  for (const Vec3d& x : out.state.x) lowest = std::min(lowest, x.z);
  CHECK(lowest > 0.4 - 0.5 * p.domain.dx());  // a particle can sink half a cell below the last free node
  // Nothing damps an elastic body but the transfers, which filter what the grid does not resolve: total energy falls in
  // every frame (up to rounding of a sum of 4,096 floats and the step's own swing), and 3 s later one twentieth of the
  // energy of the fall is left in motion.
  const Balance& last = out.result.balances.back();
  for (size_t f = 1; f < out.result.balances.size(); ++f) {
    const Balance &a = out.result.balances[f - 1], &b = out.result.balances[f];
    CHECK(b.kinetic + b.elastic + b.gravity <= 1.001 * (a.kinetic + a.elastic + a.gravity));
  }
  CHECK(last.kinetic < 0.05 * last.mass * 9.8 * 0.1);
  double highest = 0;
  for (const Vec3d& x : out.state.x) highest = std::max(highest, x.z);
  CHECK(highest > 0.7);  // it kept its height of 0.4, less what its weight presses out
}

TEST_CASE("mpm colliders: sticky stops, slip slides along, separate lets go") {
  const auto slide = [](Collider::Mode mode, const Vec3d& velocity) {
    Problem p = scene({Branch::jelly, 1e5, 0.3, 1000}, 40, {0, 0, 0});
    add_block(p, {0.8, 0.8, 0.41}, {1.0, 1.0, 0.6}, 0, p.domain.dx(), 0, velocity);
    p.domain.colliders.push_back(floor_at(0.4, mode, 0));
    return mean(simulate(p, {2, 0.1, 200}).state.v);
  };
  const Vec3d stuck = slide(Collider::Mode::sticky, {0.3, 0, 0});
  CHECK(std::fabs(stuck.x) < 0.3);  // held at its foot: it sways instead of sliding on
  const Vec3d slid = slide(Collider::Mode::slip, {0.3, 0, 0});
  CHECK(slid.x == doctest::Approx(0.3).epsilon(1e-9));
  const Vec3d held = slide(Collider::Mode::slip, {0, 0, 0.3});
  CHECK(held.z < 0.2);  // slip keeps the foot on the plane
  const Vec3d free = slide(Collider::Mode::separate, {0, 0, 0.3});
  CHECK(free.z == doctest::Approx(0.3).epsilon(1e-9));
}

TEST_CASE("mpm colliders: Coulomb friction slows a sliding block by mu g, on a level and on a tilted plane") {
  const double mu = 0.3, g = 9.8;
  Problem p = scene({Branch::jelly, 2e5, 0.3, 1000}, 40, {0, 0, -g});
  add_block(p, {0.5, 0.8, 0.4}, {0.9, 1.2, 0.5}, 0, p.domain.dx(), 0, {1.5, 0, 0});
  p.domain.colliders.push_back(floor_at(0.4, Collider::Mode::separate, mu));
  const Outcome level = simulate(p, {6, 0.04, 160});
  // From frame 1 on, when the landing is over. Contact nodes lie up to a cell inside the block's foot, so the support
  // force fluctuates with the settling; its mean is the weight.
  const double first = level.result.balances[1].momentum.x, last = level.result.balances[5].momentum.x;
  CHECK((first - last) / (level.result.balances[0].mass * 0.16) == doctest::Approx(mu * g).epsilon(0.05));

  // On a plane tilted by 30 degrees the acceleration is g (sin 30 − mu cos 30).
  Problem q = scene({Branch::jelly, 2e5, 0.3, 1000}, 40, {g * 0.5, 0, -g * std::sqrt(0.75)});
  add_block(q, {0.5, 0.8, 0.4}, {0.9, 1.2, 0.5}, 0, q.domain.dx(), 0);
  q.domain.colliders = p.domain.colliders;
  const Outcome tilted = simulate(q, {7, 0.04, 160});
  const double gain = tilted.result.balances[6].momentum.x - tilted.result.balances[2].momentum.x;
  CHECK(gain / (tilted.result.balances[0].mass * 0.16) ==
        doctest::Approx(g * (0.5 - mu * std::sqrt(0.75))).epsilon(0.05));
}

TEST_CASE("mpm colliders: box and sphere hold what falls on them") {
  for (const bool box : {true, false}) {
    Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 40, {0, 0, -9.8});
    add_block(p, {0.9, 0.9, 0.85}, {1.1, 1.1, 1.0}, 0, p.domain.dx());
    Collider c;
    c.type = box ? Collider::Type::box : Collider::Type::sphere;
    c.mode = Collider::Mode::sticky;
    c.center = {1, 1, 0.5};
    c.half_size = {0.3, 0.3, 0.3};
    c.radius = 0.3;
    p.domain.colliders.push_back(c);
    const Outcome out = simulate(p, {16, 0.04, 80}, options(Precision::single));
    CHECK(out.result.status == Status::stable);
    CHECK(mean(out.state.x).z > 0.8);
  }
}

TEST_CASE("mpm omitted: what the scene does not need is listed") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000});
  add_block(p, {0.9, 0.9, 0.9}, {1.1, 1.1, 1.1}, 0, p.domain.dx());
  const auto omitted = simulate(p, {2, 0.01, 10}).result.omitted;
  const auto has = [&](const std::string& what) {
    for (const Omission& o : omitted)
      if (o.what == what) return !o.why.empty();
    return false;
  };
  CHECK(has("principal stretches"));
  CHECK(has("branch Sand"));
  CHECK(!has("branch Jelly"));
  CHECK(has("colliders"));
  CHECK(has("empty grid blocks"));
}
