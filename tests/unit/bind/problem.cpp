// The whole problem of a candidate.
#include "bind/problem.h"

#include <doctest/doctest.h>

#include "unit/bind/scenes.h"
#include "unit/input_error.h"

using namespace physmas;

TEST_CASE("bind: particles in the state's order, at rest") {
  const State state = bind_test::state();
  const mpm::Particles particles = bind::bind_particles(state);
  REQUIRE(particles.size() == 3);
  for (size_t i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) CHECK(particles.position[i][k] == double(state.position[i][k]));
    CHECK(particles.volume[i] == double(state.volume[i]));
    CHECK(particles.row[i] == state.row[i]);
  }
  CHECK(particles.velocity.empty());
  CHECK(particles.deformation_gradient.empty());
}

TEST_CASE("bind: a problem has all its parts, and the solver takes it") {
  RunSpecification run;
  run.grid.n = 32;
  run.profile.foam_yield = 77;
  Candidate candidate = bind_test::candidate();
  ScheduleOperation push;
  push.kind = ScheduleOperation::Kind::translation;
  push.rows = {1};
  push.end = 0.1;
  candidate.schedule = {push};
  const mpm::Problem problem = bind::bind_problem(candidate, bind_test::state(), run, {"s.h5", "c.json"});
  CHECK(problem.domain.n == 32);
  CHECK(problem.materials[2].branch == mpm::Branch::sand);
  CHECK(problem.constants.foam_yield == 77);
  CHECK(problem.particles.size() == 3);
  CHECK(problem.schedule.actions.size() == 1);
  mpm::check_problem(problem, {});
}

TEST_CASE("bind: a state for a cube of another size is refused") {
  RunSpecification run;
  run.grid.length = 3;
  CHECK(message_of([&] {
          bind::bind_problem(bind_test::candidate(), bind_test::state(), run, {"s.h5", "c.json"});
        }) == "s.h5: /map/@L: found 2, expected 3, the run's grid length; make the state again with pm-lift");
}
