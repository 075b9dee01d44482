// Which rows keep their shape.
#include "mpm/rigid/stiff_rows.h"

#include <doctest/doctest.h>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

RigidPlan planned(const Problem& p, StiffRule rule, double dt = 2e-4) {
  std::vector<Branch> branches;
  std::vector<MaterialParameters<double>> parameters;
  for (const Material& m : p.materials) {
    branches.push_back(m.branch);
    parameters.push_back(derive_parameters(m, p.constants));
  }
  const std::vector<ParticleElasticity<double>> none;
  return plan_rigid({p.domain.dx(), p.domain.gravity, branches, parameters, none, p.object, p.particles,
                     p.schedule.actions, p.contact.bodies() > 1},
                    rule, dt);
}

const Material kSteel = {Branch::metal, 2e11, 0.3, 7800}, kRubber = {Branch::jelly, 1e5, 0.45, 1000};

// A steel block, a rubber one beside it.
Problem two_blocks() {
  Problem p = scene(kSteel, 50, {0, 0, -9.8});
  p.materials.push_back(kRubber);
  p.object = {0, 1};
  const double dx = p.domain.dx();
  add_block(p, {0.5, 0.5, 0.5}, {0.7, 0.7, 0.7}, 0, dx);
  add_block(p, {1.1, 0.5, 0.5}, {1.3, 0.7, 0.7}, 1, dx);
  return p;
}

}  // namespace

TEST_CASE("a row that the substep cannot integrate is one rigid body with its particles' mass, centre and inertia") {
  const Problem p = two_blocks();
  CHECK(planned(p, StiffRule::off).rows.empty());
  const RigidPlan plan = planned(p, StiffRule::automatic);
  REQUIRE(plan.rows.size() == 1);
  CHECK(plan.rows[0].row == 0);
  CHECK(plan.rows[0].rigid);
  REQUIRE(plan.setup.bodies.size() == 1);
  const RigidBodyRest& body = plan.setup.bodies[0];
  double mass = 0;
  Vec3d sum{0, 0, 0};
  for (size_t i = 0; i < p.particles.size(); ++i) {
    if (p.particles.row[i] != 0) continue;
    mass += 7800 * p.particles.volume[i];
    sum = sum + (7800 * p.particles.volume[i]) * p.particles.position[i];
  }
  CHECK(body.mass == doctest::Approx(mass).epsilon(1e-12));
  CHECK(norm(body.center - (1 / mass) * sum) < 1e-12);
  // A cube of edge 0.2, and what the grid adds.
  const double dx = p.domain.dx();
  CHECK(body.inertia[0][0] == doctest::Approx(mass * (0.04 / 6 + dx * dx / 2)).epsilon(0.05));
  CHECK(plan.row == p.particles.row);
  CHECK(plan.setup.body_of_row == std::vector<int>{0, -1});
}

TEST_CASE(
    "rows that yield, that an action deforms, or of objects that are separate bodies deform, and the plan says why") {
  Problem p = two_blocks();
  const auto why = [&](const Problem& q) {
    const RigidPlan plan = planned(q, StiffRule::automatic);
    REQUIRE(plan.rows.size() == 1);
    CHECK_FALSE(plan.rows[0].rigid);
    CHECK(plan.setup.empty());
    return plan.rows[0].why;
  };
  Problem yielding = p;
  yielding.materials[0].branch = Branch::plasticine;
  CHECK(why(yielding) == "Plasticine yields");
  Problem pressed = p;
  pressed.schedule.actions.push_back(VerticalCompress{{0}});
  CHECK(why(pressed) == "a press acts on it");
  Problem held_twice = p;
  held_twice.schedule.actions.push_back(Translation{{0}, {1, 0, 0}, 0, 1});
  held_twice.schedule.actions.push_back(SlabMotion{{0}});
  CHECK(why(held_twice) == "several actions hold it");
  Problem separate = p;
  separate.contact.body = {0, 1};
  CHECK(why(separate) == "objects are separate bodies in contact");
  Problem nearly = p;
  nearly.materials[0] = {Branch::jelly, 1e8, 0.3, 2000};
  CHECK(why(nearly) == "smaller substeps are cheaper");
}

TEST_CASE("what touches of one object is welded, of two objects it is not, and pieces that do not touch are bodies") {
  Problem p = scene(kSteel, 50, {0, 0, -9.8});
  p.materials.push_back({Branch::jelly, 1e10, 0.2, 2500});
  const double dx = p.domain.dx();
  add_block(p, {0.5, 0.5, 0.5}, {0.7, 0.7, 0.7}, 0, dx);
  add_block(p, {0.7, 0.5, 0.5}, {0.9, 0.7, 0.7}, 1, dx);
  add_block(p, {1.3, 0.5, 0.5}, {1.5, 0.7, 0.7}, 1, dx);
  p.object = {0, 0};
  const RigidPlan welded = planned(p, StiffRule::automatic);
  REQUIRE(welded.setup.bodies.size() == 2);
  // The heavier first: steel with what is welded to it. The second row's other piece has a row of its own inside.
  CHECK(welded.rows[0].bodies == std::vector<int>{0});
  CHECK(welded.rows[1].bodies == std::vector<int>{0, 1});
  CHECK(welded.source_row == std::vector<int>{0, 1, 1});
  CHECK(welded.setup.body_of_row == std::vector<int>{0, 0, 1});
  for (size_t i = 0; i < p.particles.size(); ++i) CHECK(welded.source_row[welded.row[i]] == p.particles.row[i]);
  p.object = {0, 1};
  CHECK(planned(p, StiffRule::automatic).setup.bodies.size() == 3);
}

TEST_CASE("a slender row that bends under its own weight deforms, unless it is asked to be rigid") {
  Problem p = scene({Branch::jelly, 3e8, 0.3, 7000}, 50, {0, 0, -9.8});
  const double dx = p.domain.dx();
  add_block(p, {0.2, 0.9, 0.9}, {1.8, 0.98, 0.94}, 0, dx, 0);
  const RigidPlan plan = planned(p, StiffRule::automatic, 2e-3);
  REQUIRE(plan.rows.size() == 1);
  CHECK_FALSE(plan.rows[0].rigid);
  CHECK(plan.rows[0].deflection > 0.01);
  CHECK(plan.rows[0].why.find("it bends by") == 0);
  CHECK(planned(p, StiffRule::rigid, 2e-3).rows[0].rigid);
}

TEST_CASE("crumbs beyond the number of bodies go with the nearest large piece of their object") {
  Problem p = scene(kSteel, 50, {0, 0, -9.8});
  const double dx = p.domain.dx();
  for (int k = 0; k < kMostRigidBodies + 2; ++k) {
    const double x = 0.2 + 0.18 * k, edge = 0.06 - 0.004 * k;
    add_block(p, {x, 0.9, 0.9}, {x + edge, 0.9 + edge, 0.9 + edge}, 0, dx, 0);
  }
  const RigidPlan plan = planned(p, StiffRule::automatic);
  CHECK(plan.setup.bodies.size() == kMostRigidBodies);
  size_t particles = 0;
  for (const RigidBodyRest& body : plan.setup.bodies) particles += body.particles.size();
  CHECK(particles == p.particles.size());
}
