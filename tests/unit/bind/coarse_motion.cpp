// The motion of a preview: what falls falls as it does on the run's own grid, it comes to lie where it would, and
// nothing takes long.
#include "bind/coarse_motion.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "unit/bind/scenes.h"

using namespace physmas;
using doctest::Approx;

namespace {

RunSpecification specification() {
  RunSpecification run;
  run.grid.n = 50;
  run.time.frames = 21;
  return run;
}

// A block of a/x, 0.4 m wide and high, whose lowest particles lie at `bottom`.
State block(float bottom) {
  State state;
  state.row_keys = {"a/x"};
  constexpr float kSpacing = 0.02f;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      for (int k = 0; k < 20; ++k) {
        state.position.push_back({0.8f + kSpacing * i, 0.8f + kSpacing * j, bottom + kSpacing * k});
        state.volume.push_back(kSpacing * kSpacing * kSpacing);
        state.row.push_back(0);
        state.gaussian_row.push_back(0);
        state.gaussian_object.push_back(0);
      }
    }
  }
  return state;
}

Candidate of(double E) {
  Candidate candidate;
  candidate.id = "posterior";
  candidate.rows = {bind_test::row("a/x", 0, Branch::jelly, E, 0.3, 1000)};
  candidate.timestep.substeps = 200;
  candidate.timestep.dt = 2e-4;
  return candidate;
}

float lowest(const RolloutFrame& frame) {
  float z = 10;
  for (size_t q = 0; q < frame.position.size() / 3; ++q) z = std::min(z, frame.position[3 * q + 2]);
  return z;
}

}  // namespace

TEST_CASE("coarse motion: a block falls freely and bounces from the floor of the run's own grid") {
  const State state = block(0.6f);
  const bind::CoarseMotion motion = bind::coarse_motion(of(1e5), state, specification(), {}, 11, false);
  CHECK(motion.reason == "");
  CHECK(motion.cells == 25);
  CHECK(motion.rest.size() < state.position.size() / 6);
  CHECK(motion.rest.size() == motion.row.size());
  REQUIRE(motion.frames.size() == 11);
  CHECK(motion.times.back() == Approx(0.8));
  for (size_t q = 0; q < motion.rest.size(); ++q) {
    for (int k = 0; k < 3; ++k) CHECK(motion.frames[0].position[3 * q + k] == Approx(motion.rest[q][k]));
  }
  const float fallen = lowest(motion.frames[0]) - lowest(motion.frames[3]);
  CHECK(fallen == Approx(0.5 * 9.8 * motion.times[3] * motion.times[3]).epsilon(0.05));
  // It bounces from there: three cells of the run's 0.04 m are wall, and half of one belongs to what lies on it.
  float deepest = 10;
  for (const RolloutFrame& frame : motion.frames) deepest = std::min(deepest, lowest(frame));
  CHECK(std::abs(deepest - 0.14f) < 0.04f);
}

TEST_CASE("coarse motion: what is too stiff for a quick look ends early, and says so") {
  const State state = block(0.6f);
  const bind::CoarseMotion motion = bind::coarse_motion(of(1e12), state, specification(), {}, 11, true);
  CHECK(motion.reason == "budget");
  CHECK(motion.steps < 200000);
  const bind::CoarseMotion unstable = bind::coarse_motion(of(1e12), state, specification(), {}, 11, false);
  CHECK(unstable.reason != "");
  CHECK(unstable.reason != "budget");
  CHECK(unstable.frames.size() <= 2);
}
