// The step that follows the state: its bound, its adaptation, rollback, budget; and the extremes of the stability
// study.
#include <doctest/doctest.h>

#include "base/error.h"
#include "mpm/cpu/state_summary.h"
#include "mpm/material/stiffness.h"
#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

constexpr Branch kBranches[] = {Branch::jelly, Branch::metal, Branch::sand,
                                Branch::foam,  Branch::snow,  Branch::plasticine};

MaterialParameters<double> parameters(Branch branch, double nu = 0.3) {
  return derive_parameters({branch, 1e5, nu, 1000}, {});
}

// A block of E = 3e11 on the paper's grid spacing that hits the floor: the paper's caps allow 5e-5 s.
Problem stiff_drop(double speed) {
  Problem p = scene({Branch::metal, 3e11, 0.3, 7800}, 16, {0, 0, -9.8});
  p.domain.length = 0.32;
  add_block(p, {0.13, 0.13, 0.1}, {0.17, 0.17, 0.14}, 0, p.domain.dx(), 0.2, {0, 0, -speed});
  p.domain.colliders.push_back(floor_at(0.085));
  return p;
}

Timing cfl(int frames, double frame_dt, int fewest = 1) {
  Timing t{frames, frame_dt, fewest};
  t.rule = StepRule::cfl;
  return t;
}

void check_sane(const Outcome& out, const Problem& p) {
  const double low = 2 * p.domain.dx() * (1 - 1e-6);
  for (size_t i = 0; i < out.state.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      CHECK(std::isfinite(out.state.v[i][a]));
      CHECK(out.state.x[i][a] >= low);
      CHECK(out.state.x[i][a] <= p.domain.length - low);
    }
    CHECK(std::isfinite(largest_entry(out.state.F[i])));
  }
}

}  // namespace

TEST_CASE("mpm timestep: the step is below every limit and shrinks with compression and speed") {
  Team team(1);
  for (const Branch branch : {Branch::sand, Branch::foam, Branch::snow, Branch::plasticine}) {
    StepperSetup setup;
    setup.domain = scene({branch}).domain;
    setup.branches = {branch};
    setup.parameters = {parameters(branch)};
    setup.row = {0};
    State state;
    state.x = {{1, 1, 1}};
    state.v = {{0, 0, 0}};
    state.F = {identity<double>()};
    state.C = {diagonal(0.0, 0.0, 0.0)};
    state.strength = {1e3};
    const double dx = setup.domain.dx();
    const StepBounds rest = measure_bounds(setup, state, team);
    CHECK(rest.wave <= rest_limit(setup.parameters[0], dx));
    const double dt = choose_step(rest, setup.domain, 1);
    CHECK(dt < rest.wave);
    CHECK(choose_step(rest, setup.domain, 1e-9) == 1e-9);
    state.F[0] = diagonal(0.5, 0.5, 0.5);
    const StepBounds compressed = measure_bounds(setup, state, team);
    CHECK(compressed.wave < 0.75 * rest.wave);  // log 0.5: stress of 0.7 stiffnesses
    CHECK(choose_step(compressed, setup.domain, 1) < dt);
    state.F[0] = identity<double>();
    state.v[0] = {300, 0, 0};
    CHECK(choose_step(measure_bounds(setup, state, team), setup.domain, 1) <= 0.2 * dx / 300 * (1 + 1e-12));
    state.v[0] = {0, 0, 0};
    state.C[0] = diagonal(0.0, 1e4, 0.0);
    CHECK(choose_step(measure_bounds(setup, state, team), setup.domain, 1) <= 0.3 / 1e4 * (1 + 1e-12));
  }
}

TEST_CASE("mpm timestep: what the paper's smallest step cannot integrate, cfl can, and it falls and bounces right") {
  const double speed = 20;
  Problem p = stiff_drop(speed);
  const Timing paper{3, 1e-3, 20};
  CHECK(simulate(p, paper).result.status == Status::diverged);

  // Falling freely, well above the wall.
  p.domain.colliders.clear();
  for (Vec3d& x : p.particles.position) x.z += 0.06;
  const Outcome fall = simulate(p, cfl(2, 1e-3));
  REQUIRE(fall.result.status == Status::stable);
  const double limit = rest_limit(derive_parameters(p.materials[0], {}), p.domain.dx());
  CHECK(fall.result.history.largest_dt <= 0.7 * limit);
  CHECK(fall.result.history.retries == 0);
  double worst = 0;
  for (size_t i = 0; i < p.particles.size(); ++i) {
    const double expected = p.particles.position[i].z - speed * 1e-3 - 0.5 * 9.8 * 1e-6;
    worst = std::max(worst, std::fabs(fall.state.x[i].z - expected));
  }
  // Symplectic Euler: g T dt / 2 = 9.8e-3 · 1.3e-6 / 2 = 6e-9.
  CHECK(worst < 1e-8);

  // With the floor it comes back up, with at most the energy it had.
  p = stiff_drop(speed);
  const Outcome bounce = simulate(p, cfl(5, 5e-4));
  REQUIRE(bounce.result.status == Status::stable);
  const Balance &first = bounce.result.balances.front(), &last = bounce.result.balances.back();
  CHECK(last.momentum.z > 0.5 * first.mass * speed);
  const double loss = first.kinetic - last.kinetic - last.elastic - (last.gravity - first.gravity);
  CHECK(loss > 0);
  check_sane(bounce, p);
}

TEST_CASE("mpm timestep: the largest step holds, frames are met, and threads do not matter") {
  Problem p = scene({Branch::jelly, 1e5, 0.3, 1000}, 32, {0, 0, -9.8});
  add_block(p, {0.7, 0.7, 0.3}, {1.1, 1.1, 0.7}, 0, p.domain.dx(), 0.2, {0, 0, -5});
  p.domain.colliders.push_back(floor_at(0.25));
  const Outcome one = simulate(p, cfl(4, 0.01, 50), options(Precision::single, 1));
  const Outcome two = simulate(p, cfl(4, 0.01, 50), options(Precision::single, 2));
  REQUIRE(one.result.status == Status::stable);
  CHECK(one.result.history.largest_dt <= 2e-4 * (1 + 1e-12));
  CHECK(one.result.history.time == doctest::Approx(0.03));
  CHECK(one.result.steps == one.result.history.steps);
  CHECK(one.result.steps == two.result.steps);
  for (size_t i = 0; i < one.state.size(); ++i) CHECK(one.state.x[i].z == two.state.x[i].z);
}

TEST_CASE("mpm timestep: a chunk that fails is thrown away and done again with smaller steps") {
  // At rest when the step is chosen, then an impulse of 40 cells per millisecond within it.
  Problem p = scene({Branch::jelly, 1e4, 0.3, 1000}, 32);
  add_block(p, {0.5, 0.8, 0.8}, {0.7, 1.0, 1.0}, 0, p.domain.dx());
  const double speed = 400;
  p.schedule.actions.push_back(Impulse{{0}, {speed, 0, 0}, 1e-4, 1e-5, 1e-5});
  const Outcome out = simulate(p, cfl(2, 1e-3));
  REQUIRE(out.result.status == Status::stable);
  CHECK(out.result.history.retries > 0);
  CHECK(out.result.history.discarded_steps > 0);
  CHECK(out.result.max_speed * out.result.history.smallest_dt < 0.41 * p.domain.dx());
  // Nothing of the failed attempts is left: the body moves with the impulse's speed, once.
  CHECK(mean(out.state.v).x == doctest::Approx(speed).epsilon(1e-6));
  CHECK(mean(out.state.x).x - mean(p.particles.position).x == doctest::Approx(speed * 9e-4).epsilon(0.01));
}

TEST_CASE("mpm timestep: the budget ends a run before it begins, or when it is used up") {
  Problem p = stiff_drop(20);
  Options few = options();
  few.max_steps = 100;
  const Outcome refused = simulate(p, cfl(2, 0.04), few);
  CHECK(refused.result.status == Status::diverged);
  CHECK(refused.result.reason == "budget");
  CHECK(refused.result.first_bad_step == 0);
  CHECK(refused.result.frames_done == 1);

  // A soft body at rest promises few steps, then an impulse asks for many.
  p = scene({Branch::jelly, 1e4, 0.3, 1000}, 32);
  add_block(p, {0.5, 0.8, 0.8}, {0.6, 0.9, 0.9}, 0, p.domain.dx());
  p.schedule.actions.push_back(Impulse{{0}, {400, 0, 0}, 1e-3, 1e-5, 1e-5});
  few.max_steps = 60;
  const Outcome used = simulate(p, cfl(11, 5e-4, 1), few);
  CHECK(used.result.reason == "budget");
  CHECK(used.result.frames_done > 1);
  CHECK(used.result.steps + used.result.history.discarded_steps <= few.max_steps + 1);

  const Outcome fixed = simulate(p, {3, 0.01, 50}, few);
  CHECK(fixed.result.reason == "budget");
  CHECK(fixed.result.first_bad_step == 0);
}

TEST_CASE("mpm faults: an instability too weak for the substeps' check is found at the next output frame") {
  // dt = 1.18 limits: it saturates at some two or three times the energy of the impact, which no single check of
  // kinetic energy takes for impossible.
  Problem p = scene({Branch::jelly, 1e9, 0, 4500}, 16, {0, 0, -9.8});
  p.domain.length = 0.32;
  add_block(p, {0.13, 0.13, 0.106}, {0.19, 0.19, 0.166}, 0, p.domain.dx(), 0.2, {7, 0, -23.6});
  p.domain.colliders.push_back(floor_at(0.086, Collider::Mode::separate, 0.4));
  const Outcome out = simulate(p, {21, 5e-4, 10});
  CHECK(out.result.status == Status::diverged);
  CHECK(out.result.reason == "energy");
  CHECK(simulate(p, cfl(11, 5e-4)).result.status == Status::stable);
}

TEST_CASE("mpm faults: a step far above the limit is named where a stress cone hides the instability") {
  for (const Branch branch : {Branch::sand, Branch::snow, Branch::plasticine}) {
    Problem p = scene({branch, 1e9, 0.2, 4500}, 16);
    p.domain.length = 0.32;
    add_block(p, {0.13, 0.13, 0.13}, {0.16, 0.16, 0.16}, 0, p.domain.dx());
    const double limit = rest_limit(derive_parameters(p.materials[0], {}), p.domain.dx());
    const auto at = [&](double share) { return simulate(p, {2, 10 * share * limit, 10}).result; };
    CHECK(at(1.6).reason == "step");
    CHECK(at(1.4).status == Status::stable);
    // Particles that an action moves have no motion of their own.
    p.schedule.actions.push_back(Translation{{0}, {0.1, 0, 0}, 0, 1});
    CHECK(at(1.6).status == Status::stable);
  }
}

TEST_CASE("mpm extremes: deformed, inverted and collapsed starts are stable under cfl, with bounded energy") {
  for (const Branch branch : kBranches) {
    for (const Mat3d& F : {diagonal(1.0, 1.0, -1.0), diagonal(0.0, 0.0, 0.0), diagonal(0.3, 0.3, 0.3),
                           diagonal(1.0, 1.0, 0.0), diagonal(3.0, 3.0, 3.0)}) {
      Problem p = scene({branch, 1e5, 0.3, 1000}, 16, {0, 0, -9.8});
      add_block(p, {0.8, 0.8, 0.8}, {1.1, 1.1, 1.1}, 0, p.domain.dx());
      p.particles.deformation_gradient.assign(p.particles.size(), F);
      const Outcome out = simulate(p, cfl(3, 0.01), options(Precision::single, 1));
      INFO(std::string(branch_name(branch)), " F = ", F[0].x, " ", F[1].y, " ", F[2].z);
      CHECK(out.result.status == Status::stable);
      const Balance &first = out.result.balances.front(), &last = out.result.balances.back();
      CHECK(last.kinetic <= 1.01 * (first.elastic + first.mass * 9.8 * 0.02));
      check_sane(out, p);
    }
  }
  Problem p = scene({Branch::jelly, 1e5, 0.3, 1000}, 16);
  add_block(p, {0.8, 0.8, 0.8}, {1.1, 1.1, 1.1}, 0, p.domain.dx());
  p.particles.deformation_gradient.assign(3, identity<double>());
  CHECK_THROWS_AS(simulate(p, {2, 0.01, 10}), Error);
  p.particles.deformation_gradient.assign(p.particles.size(), diagonal(1.0, std::nan(""), 1.0));
  CHECK_THROWS_AS(simulate(p, {2, 0.01, 10}), Error);
}

TEST_CASE("mpm extremes: sheets, faces, walls, thousandfold gravity and stiff next to soft are stable under cfl") {
  const auto run_it = [](const Problem& p, double seconds) {
    const Outcome out = simulate(p, cfl(3, seconds / 2, 20), options(Precision::single, 1));
    CHECK(out.result.status == Status::stable);
    check_sane(out, p);
  };
  for (const Branch branch : kBranches) {
    INFO(std::string(branch_name(branch)));
    Problem sheet = scene({branch, 1e5, 0.3, 1000}, 16, {0, 0, -9.8});
    add_block(sheet, {0.8, 0.8, 0.45}, {1.2, 1.2, 0.5}, 0, sheet.domain.dx(), 0.2, {1, 0, -2});
    run_it(sheet, 0.1);
    Problem heavy = scene({branch, 1e5, 0.3, 1000}, 16, {0, 0, -9800});
    add_block(heavy, {0.8, 0.8, 0.5}, {1.1, 1.1, 0.8}, 0, heavy.domain.dx());
    run_it(heavy, 0.02);
  }
  Problem faces = scene({Branch::jelly, 1e5, 0.3, 1000}, 16, {0, 0, -9.8});
  for (int i = 0; i < 8; ++i) {
    faces.particles.position.push_back({1 + 0.0625 * (i & 1), 1 + 0.0625 * (i >> 1 & 1), 0.375 + 0.0625 * (i >> 2)});
    faces.particles.volume.push_back(1e-4);
    faces.particles.row.push_back(0);
  }
  run_it(faces, 0.2);
  Problem pair = scene({Branch::metal, 1e11, 0.3, 1000}, 16, {0, 0, -9.8});
  pair.materials.push_back({Branch::jelly, 1e3, 0.3, 1000});
  add_block(pair, {0.8, 0.8, 0.5}, {1.1, 1.1, 0.65}, 0, pair.domain.dx(), 0.2, {0, 0, -1});
  add_block(pair, {0.8, 0.8, 0.65}, {1.1, 1.1, 0.8}, 1, pair.domain.dx(), 0.2, {0, 0, -1});
  run_it(pair, 1e-3);
}
