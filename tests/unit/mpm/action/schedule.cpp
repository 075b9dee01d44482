// Actions, projections at output frames, and what the inelastic branches do under them.
#include "mpm/action/schedule.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

// The q-quantile of one coordinate over the particles of a row.
double quantile(const Problem& p, const State& s, int row, int axis, double q) {
  std::vector<double> values;
  for (size_t i = 0; i < s.size(); ++i)
    if (p.particles.row[i] == row) values.push_back(s.x[i][axis]);
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1))];
}

}  // namespace

TEST_CASE("mpm actions: translation moves its rows with the given velocity, during its interval only") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32);
  p.materials.push_back({Branch::jelly, 5e4, 0.3, 1000});
  add_block(p, {0.6, 0.8, 0.8}, {0.8, 1.0, 1.0}, 0, p.domain.dx());
  add_block(p, {1.4, 0.8, 0.8}, {1.6, 1.0, 1.0}, 1, p.domain.dx());
  p.schedule.actions.push_back(Translation{{0}, {0.5, 0, 0.25}, 0.05, 0.15});
  const Outcome out = simulate(p, {5, 0.05, 100});
  for (size_t i = 0; i < p.particles.size(); ++i) {
    const Vec3d moved = out.state.x[i] - p.particles.position[i];
    if (p.particles.row[i] == 1) {
      CHECK(norm(moved) == 0);  // nothing has touched it: not even rounding
    } else {
      // Enforced for 0.1 s, then coasting for 0.05 s at the same velocity, which APIC keeps exactly.
      CHECK(moved.x == doctest::Approx(0.5 * 0.15).epsilon(1e-9));
      CHECK(moved.z == doctest::Approx(0.25 * 0.15).epsilon(1e-9));
    }
  }
  // Work of the action: the kinetic energy that it put in.
  const Balance& last = out.result.balances.back();
  CHECK(last.control_work == doctest::Approx(last.kinetic).epsilon(1e-9));
}

TEST_CASE("mpm actions: top_press moves the slab nearest the top and presses the rest") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32);
  add_block(p, {0.7, 0.7, 0.4}, {1.2, 1.2, 0.9}, 0, p.domain.dx());
  p.domain.colliders.push_back(floor_at(0.4));
  const TopPress press{{0}, {0, 0, -0.5}, {0, 0, 1}, 0.2, 0, 0.2};
  p.schedule.actions.push_back(press);
  const Outcome out = simulate(p, {6, 0.04, 80});
  REQUIRE(out.result.status == Status::stable);
  const std::vector<int> slab = select_region(press, p.particles).particles;
  double low = 2, high = 0;
  for (const Vec3d& x : p.particles.position) low = std::min(low, x.z), high = std::max(high, x.z);
  size_t expected = 0;
  for (const Vec3d& x : p.particles.position) expected += x.z >= high - 0.2 * (high - low);
  CHECK(slab.size() == expected);
  for (const int i : slab) {
    // 0.2 s at 0.5 m/s, exactly: enforced particles move with their own velocity.
    CHECK(out.state.x[i].z - p.particles.position[i].z == doctest::Approx(-0.1).epsilon(1e-9));
    CHECK(std::fabs(out.state.F[i][2].z - 1) < 1e-12);
  }
  CHECK(out.result.min_J < 0.9);  // the rest is squeezed
}

TEST_CASE("mpm actions: an impulse gives the momentum asked for, whatever the substep") {
  for (const int substeps : {100, 77, 400}) {
    Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32);
    add_block(p, {0.8, 0.8, 0.8}, {1.0, 1.0, 1.0}, 0, p.domain.dx());
    // Asks for 2 ms, gets four base substeps of 0.2 ms: the total stays.
    const Impulse impulse{{0}, {1.5, 0, -0.5}, 0.01, 2e-3, 2e-4};
    CHECK(impulse.end() == doctest::Approx(0.0108));
    p.schedule.actions.push_back(impulse);
    const Outcome out = simulate(p, {3, 0.02, substeps});
    const Balance& last = out.result.balances.back();
    // The shares add up to one; the rest is rounding of a few hundred steps.
    CHECK(last.momentum.x == doctest::Approx(1.5 * last.mass).epsilon(1e-10));
    CHECK(last.momentum.z == doctest::Approx(-0.5 * last.mass).epsilon(1e-10));
  }
}

TEST_CASE("mpm actions: overlapping actions share particles, the later enforced velocity wins") {
  Problem p = scene({Branch::jelly, 5e4, 0.3, 1000}, 32);
  add_block(p, {0.8, 0.8, 0.8}, {1.0, 1.0, 1.0}, 0, p.domain.dx());
  p.schedule.actions.push_back(Translation{{0}, {0.5, 0, 0}, 0, 1});
  p.schedule.actions.push_back(TopPress{{0}, {0, 0.5, 0}, {0, 0, 1}, 0.3, 0, 1});
  const ActionPlan plan(p.schedule.actions, p.particles);
  CHECK(plan.group_count() == 3);
  std::vector<Control> controls;
  REQUIRE(plan.controls(0.5, 1e-3, controls));
  CHECK(controls[1].velocity.x == 0.5);
  CHECK(controls[2].velocity.y == 0.5);
  CHECK(!plan.controls(1.0, 1e-3, controls));
}

TEST_CASE("mpm projection: eta = 1 restores the rest shape about the moved centre and keeps linear momentum") {
  Problem p = scene({Branch::jelly, 2e4, 0.3, 1000}, 32);
  add_block(p, {0.8, 0.8, 0.8}, {1.1, 1.1, 1.1}, 0, p.domain.dx());
  for (size_t i = 0; i < p.particles.size(); ++i) {
    const Vec3d q = p.particles.position[i] - Vec3d{1, 1, 1};
    p.particles.velocity[i] = Vec3d{0.3, 0, 0} + Vec3d{q.x, -q.y, q.x};
  }
  p.schedule.projections.push_back({0, 1.0});
  const Outcome out = simulate(p, {3, 0.04, 80});
  const Vec3d moved = mean(out.state.x) - mean(p.particles.position);
  for (size_t i = 0; i < p.particles.size(); ++i) {
    // Rounding of means over a thousand particles.
    CHECK(norm(out.state.x[i] - p.particles.position[i] - moved) < 1e-13);
    CHECK(squared_norm(out.state.F[i] - identity<double>()) == 0);
    CHECK(squared_norm(out.state.C[i]) == 0);
  }
  const Vec3d change = out.result.balances.back().momentum - out.result.balances.front().momentum;
  CHECK(norm(change) < 1e-11 * out.result.balances.front().mass);
}

TEST_CASE("mpm projection: partial strength blends as the equations say") {
  Problem p = scene({Branch::jelly, 2e4, 0.3, 1000}, 32);
  add_block(p, {0.9, 0.9, 0.9}, {1.0, 1.0, 1.0}, 0, p.domain.dx());
  State s;
  s.x = p.particles.position;
  for (Vec3d& x : s.x) x = {2 * x.x, x.y + 0.1, x.z};
  s.v.assign(s.size(), {1, 2, 3});
  s.v[0] = {2, 2, 3};
  s.F.assign(s.size(), diagonal(2.0, 1.0, 1.0));
  s.C.assign(s.size(), identity<double>());
  const State before = s;
  CompiledProjection({0, 0.25}, p.particles).apply(s);
  const Vec3d center = mean(before.x), rest = mean(p.particles.position), velocity = mean(before.v);
  for (size_t i = 0; i < s.size(); ++i) {
    const Vec3d target = center + (p.particles.position[i] - rest);
    CHECK(norm(s.x[i] - (0.75 * before.x[i] + 0.25 * target)) < 1e-14);
    CHECK(norm(s.v[i] - (0.75 * before.v[i] + 0.25 * velocity)) < 1e-14);
    CHECK(s.F[i][0].x == doctest::Approx(1.75));
    CHECK(s.C[i][1].y == doctest::Approx(0.75));
  }
}

TEST_CASE("mpm retention: nearest support, distance, limit, ties and weights") {
  // A support of two particles, a second support, and a line of particles of row 2.
  Problem p = scene({Branch::jelly, 2e4, 0.3, 1000}, 32);
  const auto add = [&](double x, int row) {
    p.particles.position.push_back({x, 1, 1});
    p.particles.volume.push_back(1e-6);
    p.particles.row.push_back(row);
  };
  add(1.00, 0);
  add(0.98, 0);
  add(1.10, 1);
  for (int k = 0; k < 10; ++k) add(1.01 + 0.01 * k, 2);  // indices 3..12
  InterfaceRetention first{0, {2}}, second{1, {2}};
  const auto both = CompiledRetention::compile({first, second}, p.particles);
  // 1.01..1.04 are nearest to row 0 within 0.045; 1.05 lies at the same distance from both (up to rounding), 0.05:
  // none; 1.06..1.10 belong to row 1.
  CHECK(both[0].particles() == std::vector<int>{3, 4, 5, 6});
  CHECK(both[1].particles().size() == 5);
  CHECK(both[1].particles()[0] == 12);
  first.limit = 2;
  const auto limited = CompiledRetention::compile({first}, p.particles);
  CHECK(limited[0].particles() == std::vector<int>{3, 4});

  State s;
  s.x = p.particles.position;
  s.v.assign(s.size(), {0, 0, 0});
  s.F.assign(s.size(), diagonal(1.5, 1.0, 1.0));
  s.C.assign(s.size(), identity<double>());
  s.x[0].y += 0.2, s.x[1].y += 0.2;  // the support moves up
  s.v[0].y = s.v[1].y = 2;
  limited[0].apply(s);
  CHECK(s.x[3].y == doctest::Approx(1 + 0.95 * 0.2));
  CHECK(s.v[3].y == doctest::Approx(0.95 * 2));
  CHECK(s.x[3].x == doctest::Approx(1.01));
  CHECK(s.F[3][0].x == 1.5);  // retention leaves F and the affine state alone
  CHECK(s.x[5].y == 1.0);

  // Positions and velocities have weights of their own.
  first.eta = 0.25, first.zeta = 0.75;
  s.x[3].y = 1, s.v[3].y = 0;
  CompiledRetention::compile({first}, p.particles)[0].apply(s);
  CHECK(s.x[3].y == doctest::Approx(1 + 0.25 * 0.2));
  CHECK(s.v[3].y == doctest::Approx(0.75 * 2));
}

TEST_CASE("mpm materials: pressed plasticine keeps its dent, pressed jelly springs back, foam creeps") {
  const auto height_after = [](Branch branch, double seconds_held) {
    Problem p = scene({branch, 1e5, 0.3, branch == Branch::foam ? 300.0 : 1000.0}, 32);
    add_block(p, {0.7, 0.7, 0.4}, {1.1, 1.1, 0.8}, 0, p.domain.dx());
    p.domain.colliders.push_back(floor_at(0.4, Collider::Mode::separate, 0.5));
    p.schedule.actions.push_back(TopPress{{0}, {0, 0, -0.5}, {0, 0, 1}, 0.15, 0, 0.2});
    p.schedule.actions.push_back(TopPress{{0}, {0, 0, 0}, {0, 0, 1}, 0.15, 0.2, 0.2 + seconds_held});
    const int frames = 6 + static_cast<int>(std::lround((seconds_held + 0.2) / 0.04));
    const Outcome out = simulate(p, {frames, 0.04, 100}, options(Precision::single));
    CHECK(out.result.status == Status::stable);
    return quantile(p, out.state, 0, 2, 0.98) - quantile(p, out.state, 0, 2, 0.02);
  };
  // Rest height 0.4 (0.384 between the quantiles), pressed by 0.1, then released for 0.2 s without gravity.
  const double jelly = height_after(Branch::jelly, 0);
  const double plasticine = height_after(Branch::plasticine, 0);
  const double foam = height_after(Branch::foam, 0), foam_held = height_after(Branch::foam, 0.4);
  MESSAGE("height after release: jelly ", jelly, ", plasticine ", plasticine, ", foam ", foam, ", foam held ",
          foam_held);
  CHECK(jelly > 0.33);  // swinging about its rest height
  CHECK(plasticine < 0.32);
  CHECK(foam < 0.36);               // beyond its yield strength it has flowed
  CHECK(foam_held < foam + 0.005);  // and holding it longer does not let it recover
}

TEST_CASE("mpm materials: a sand column runs out, snow and jelly of the same shape do not") {
  const auto spread = [](Branch branch) {
    Problem p = scene({branch, 1e5, 0.3, 1500}, 40, {0, 0, -9.8});
    add_block(p, {0.85, 0.85, 0.4}, {1.15, 1.15, 0.8}, 0, p.domain.dx());
    p.domain.colliders.push_back(floor_at(0.4, Collider::Mode::separate, 0.5));
    const Outcome out = simulate(p, {21, 0.04, 120}, options(Precision::single));
    CHECK(out.result.status == Status::stable);
    return quantile(p, out.state, 0, 0, 0.95) - quantile(p, out.state, 0, 0, 0.05);
  };
  const double rest = 0.27;  // the middle 90 % of 0.3
  const double sand = spread(Branch::sand), snow = spread(Branch::snow), jelly = spread(Branch::jelly);
  MESSAGE("width: sand ", sand, ", snow ", snow, ", jelly ", jelly);
  CHECK(sand > 2 * rest);
  CHECK(jelly < 1.2 * rest);
  CHECK(snow < sand);
}
