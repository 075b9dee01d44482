// Frames are observations: how many are written changes no motion.
#include <doctest/doctest.h>

#include <string>

#include "unit/mpm/scenes.h"

using namespace mpm_test;

namespace {

// A block that is thrown at a floor and pressed from above, so that every branch yields.
Problem pressed_block(Branch branch) {
  Problem p = scene({branch, 5e4, 0.3, 1000}, 32, {0, 0, -9.8});
  p.constants.plasticine_softening = 2e4;  // as much as is at stake
  p.domain.colliders.push_back(floor_at(0.6, Collider::Mode::separate, 0.4));
  add_block(p, {0.8, 0.8, 0.6}, {1.15, 1.1, 0.9}, 0, p.domain.dx(), 0.2, {0.3, 0, -0.5});
  p.schedule.actions.push_back(TopPress{{0}, {0, 0, -1.5}, {0, 0, 1}, 0.2, 0, 0.03});
  return p;
}

// Largest difference of places [cells], velocities [cells per unit of time] and F between two states.
double difference(const Problem& p, const State& a, const State& b, double duration) {
  double most = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, norm(a.x[i] - b.x[i]) / p.domain.dx());
    most = std::max(most, norm(a.v[i] - b.v[i]) * duration / p.domain.dx());
    most = std::max(most, std::sqrt(squared_norm(a.F[i] - b.F[i])));
  }
  return most;
}

}  // namespace

TEST_CASE("mpm frames: forty substeps are the same motion with one output frame and with forty") {
  constexpr int kSteps = 40;
  const double dt = 5e-4, duration = kSteps * dt;
  for (const Precision precision : {Precision::full, Precision::single}) {
    const double rounding = precision == Precision::full ? kEpsilon<double> : double(kEpsilon<float>);
    for (int b = 0; b < kBranchCount; ++b) {
      const Problem p = pressed_block(static_cast<Branch>(b));
      const Outcome one = simulate(p, {2, duration, kSteps}, options(precision));
      const Outcome many = simulate(p, {kSteps + 1, dt, 1}, options(precision));
      REQUIRE(one.result.steps == many.result.steps);
      const Branch branch = static_cast<Branch>(b);
      INFO(std::string(branch_name(branch)));
      const double apart = difference(p, one.state, many.state, duration) / rounding;
      // The substep before a frame is another instantiation of the pass, in which fused multiply-adds may fall
      // differently; and the one after it takes the stress of the F that the return map wrote, not of the strain that
      // it gave. Both are some roundings in each of forty frames.
      CHECK(apart < 100);
      // The motion is no rest, and what yields has yielded.
      double farthest = 0;
      for (size_t i = 0; i < one.state.size(); ++i)
        farthest = std::max(farthest, norm(one.state.x[i] - p.particles.position[i]));
      CHECK(farthest > 0.1 * p.domain.dx());
      if (branch == Branch::plasticine) {
        double lowest = p.constants.plasticine_yield;
        for (const double s : one.state.strength) lowest = std::min(lowest, s);
        CHECK(lowest < 0.9 * p.constants.plasticine_yield);
      }
    }
  }
}
