// Materials that differ from particle to particle.
#include <doctest/doctest.h>

#include <cmath>

#include "base/error.h"
#include "mpm/equilibrium.h"
#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

const Material kSoft = {Branch::jelly, 4e4, 0.25, 900}, kHard = {Branch::jelly, 9e4, 0.4, 1300};

// A block that falls onto a floor, its lower half soft: as two rows, or as one row with a field.
Problem halves(bool as_field) {
  Problem p = scene(kSoft, 24, {0.3, 0, -9.8});
  const double dx = p.domain.dx();
  p.domain.colliders.push_back(floor_at(5 * dx, Collider::Mode::separate, 0.4));
  p.materials = {kSoft, kHard};
  add_block(p, {9 * dx, 9 * dx, 5.2 * dx}, {15 * dx, 15 * dx, 8.2 * dx}, 0, dx / 2, 0, {0, 0, -1});
  add_block(p, {9 * dx, 9 * dx, 8.2 * dx}, {15 * dx, 15 * dx, 11.2 * dx}, 1, dx / 2, 0, {0, 0, -1});
  if (!as_field) return p;
  for (int& row : p.particles.row) {
    p.particles.material.push_back(p.materials[row]);
    row = 0;
  }
  // What the row itself says must not count.
  p.materials = {{Branch::jelly, 7e3, 0.1, 200}};
  return p;
}

}  // namespace

TEST_CASE("particle materials: two constant halves are two rows") {
  for (const StepRule rule : {StepRule::fixed, StepRule::cfl}) {
    const Timing timing{6, 0.02, 100, rule};
    Options o = options();
    o.measure_steps = true;
    const Outcome rows = simulate(halves(false), timing, o), field = simulate(halves(true), timing, o);
    REQUIRE(rows.result.status == Status::stable);
    CHECK(rows.result.steps == field.result.steps);
    double most = 0, moved = 0;
    for (size_t i = 0; i < rows.state.size(); ++i) {
      most = std::max(most, norm(rows.state.x[i] - field.state.x[i]));
      moved = std::max(moved, norm(rows.state.x[i] - halves(false).particles.position[i]));
    }
    CHECK(moved > 0.02);
    // Double precision: the columns of a register are others, so sums have another order.
    CHECK(most < 1e-11);
    for (size_t f = 0; f < rows.result.balances.size(); ++f) {
      const Balance &a = rows.result.balances[f], &b = field.result.balances[f];
      CHECK(b.mass == doctest::Approx(a.mass).epsilon(1e-12));
      CHECK(b.energy() == doctest::Approx(a.energy()).epsilon(1e-9));
      CHECK(b.budget.residual() == doctest::Approx(a.budget.residual()).epsilon(1e-6));
    }
  }
}

TEST_CASE("particle materials: a field that says what the row says changes nothing") {
  Problem p = halves(false);
  const Timing timing{3, 0.02, 100, StepRule::fixed};
  const Outcome plain = simulate(p, timing, options());
  for (const int row : p.particles.row) p.particles.material.push_back(p.materials[row]);
  const Outcome field = simulate(p, timing, options());
  for (size_t i = 0; i < plain.state.size(); ++i) CHECK(norm(plain.state.x[i] - field.state.x[i]) < 1e-12);
}

TEST_CASE("particle materials: the balance at the start and the step that is needed see them") {
  // The same rows, so that both are solved in the same order; but the field's rows say something else.
  Problem rows = halves(false), field = halves(false);
  for (const int row : field.particles.row) field.particles.material.push_back(rows.materials[row]);
  for (Material& m : field.materials) m = {Branch::jelly, 7e3, 0.1, 200};
  for (Problem* p : {&rows, &field}) {
    for (Vec3d& x : p->particles.position) x.z -= 0.2 * p->domain.dx();
    p->domain.gravity = {0, 0, -9.8};
  }
  const Equilibrium a = find_equilibrium(rows, {}), b = find_equilibrium(field, {});
  REQUIRE(a.supported_particles > 0);
  REQUIRE(a.deformation_gradient.size() == b.deformation_gradient.size());
  double most = 0;
  for (size_t i = 0; i < a.deformation_gradient.size(); ++i)
    most = std::max(most, std::sqrt(squared_norm(a.deformation_gradient[i] - b.deformation_gradient[i])));
  CHECK(most < 1e-12);
  CHECK(a.largest_strain > 1e-3);
  // A quarter is too stiff for the step: the run ends, and the smallest step that a particle needs is named.
  for (size_t i = 0; i < field.particles.size() / 4; ++i) field.particles.material[i].E = 1e10;
  const Outcome stiff = simulate(field, {6, 0.02, 100, StepRule::fixed}, options());
  CHECK(stiff.result.status == Status::diverged);
  CHECK(
      stiff.result.stiffest_limit ==
      doctest::Approx(rest_limit(derive_parameters(field.particles.material[0], field.constants), field.domain.dx())));
  CHECK(simulate(field, {2, 1e-3, 1, StepRule::cfl}, options()).result.status == Status::stable);
}

TEST_CASE("particle materials: what is outside of a material's domain is refused") {
  for (const Material& bad : {Material{Branch::jelly, -1, 0.3, 1000}, Material{Branch::jelly, 1e5, 0.5, 1000},
                              Material{Branch::jelly, 1e5, 0.3, 0}, Material{Branch::jelly, NAN, 0.3, 1000}}) {
    Problem p = halves(true);
    p.particles.material[3] = bad;
    CHECK_THROWS_AS(check_problem(p, {}), Error);
  }
  Problem p = halves(true);
  p.particles.material.pop_back();
  CHECK_THROWS_AS(check_problem(p, {}), Error);
}
