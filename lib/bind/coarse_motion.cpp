#include "bind/coarse_motion.h"

#include <algorithm>
#include <cmath>

#include "bind/start.h"
#include "bind/timing.h"
#include "mpm/companion.h"

namespace physmas::bind {
namespace {

// A substep costs about as much as this many particles, however few there are.
constexpr double kStepCost = 500;
// Particles that may be moved by a substep in all, with that cost: about 1.5 s of one core.
constexpr double kWork = 5e7;
// Of the largest stable step of the stiffest material at rest: what steps have while things move.
constexpr double kShareOfLimit = 0.4;

// lift: what everything was moved by.
RolloutFrame frame_of(const mpm::State& state, const mpm::Vec3d& lift) {
  RolloutFrame frame;
  const auto add = [](std::vector<float>& values, const mpm::Vec3d& v) {
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(v[k]));
  };
  for (size_t q = 0; q < state.size(); ++q) {
    add(frame.position, state.x[q] - lift);
    add(frame.velocity, state.v[q]);
    for (int k = 0; k < 3; ++k) add(frame.F, state.total_F[q][k]);
  }
  return frame;
}

// How far up everything is moved, so that it lies on the companion's lower wall as it does on the problem's: that wall
// is whole cells thick, and what lies on it keeps about half a cell away.
mpm::Vec3d lift_off(const mpm::Domain& fine, const mpm::Domain& coarse) {
  int axis = 0;
  for (int a = 1; a < 3; ++a) {
    if (std::abs(fine.gravity[a]) > std::abs(fine.gravity[axis])) axis = a;
  }
  mpm::Vec3d lift = {0, 0, 0};
  if (fine.gravity[axis] == 0) return lift;
  const double higher = (coarse.wall_cells + 0.5) * coarse.dx() - (fine.wall_cells + 0.5) * fine.dx();
  lift[axis] = fine.gravity[axis] < 0 ? higher : -higher;
  return lift;
}

void move_everything(mpm::Problem& problem, const mpm::Vec3d& by) {
  for (mpm::Vec3d& x : problem.particles.position) x = x + by;
  for (mpm::Collider& collider : problem.domain.colliders) collider.center = collider.center + by;
}

}  // namespace

CoarseMotion coarse_motion(const Candidate& candidate, const State& state, const RunSpecification& run,
                           const ProblemFiles& files, int pictures, bool adaptive) {
  const int factor = std::max(2, static_cast<int>(std::lround(static_cast<double>(run.grid.n) / kCoarseCells)));
  const mpm::Problem problem = bind_problem(candidate, state, run, files);
  mpm::Companion companion = mpm::make_companion(problem, factor);
  const mpm::Vec3d lift = lift_off(problem.domain, companion.problem.domain);
  move_everything(companion.problem, lift);
  bind_start(run.time, {}, companion.problem);
  const mpm::Particles& particles = companion.problem.particles;

  CoarseMotion motion;
  motion.cells = companion.problem.domain.n;
  motion.asked = (run.time.frames - 1) * run.time.frame_dt;
  motion.row.assign(particles.row.begin(), particles.row.end());
  for (const mpm::Vec3d& x : particles.position) {
    const mpm::Vec3d at = x - lift;
    motion.rest.push_back({static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
  }

  mpm::Timing timing;
  timing.frame_dt = run.time.frame_dt;
  timing.rule = adaptive ? mpm::StepRule::cfl : mpm::StepRule::fixed;
  timing.substeps = whole_substeps(factor * (adaptive ? run.time.substep_dt : candidate.timestep.dt), timing.frame_dt);
  mpm::Options options;
  options.track_total_F = true;
  options.measure_energy = false;
  options.max_steps =
      std::max(1LL, static_cast<long long>(kWork / (static_cast<double>(particles.size()) + kStepCost)));
  timing.frames = static_cast<int>(std::clamp<long long>(1 + options.max_steps / timing.substeps, 1, run.time.frames));
  // Every `every`-th frame, and the last one.
  const int every = std::max(1, (run.time.frames - 1 + pictures - 2) / std::max(1, pictures - 1));
  const auto simulate = [&] {
    motion.times.clear();
    motion.frames.clear();
    return mpm::run(companion.problem, timing, options, [&](const mpm::Frame& frame) {
      if (frame.index % every != 0 && frame.index + 1 != timing.frames) return;
      motion.times.push_back(frame.time);
      motion.frames.push_back(frame_of(frame.state, lift));
    });
  };
  mpm::Result result = simulate();
  // What is too stiff to be followed to its end is followed as far as the steps reach.
  if (result.reason == "budget" && motion.frames.size() < 2 && result.stiffest_limit > 0) {
    const double reached = kShareOfLimit * result.stiffest_limit * static_cast<double>(options.max_steps);
    timing.frames = std::min(timing.frames, 1 + static_cast<int>(std::min(reached / timing.frame_dt, 1e6)));
    if (timing.frames > 1) result = simulate();
  }
  motion.steps = result.steps;
  motion.reason = result.reason;
  if (motion.reason.empty() && timing.frames < run.time.frames) motion.reason = "budget";
  return motion;
}

}  // namespace physmas::bind
