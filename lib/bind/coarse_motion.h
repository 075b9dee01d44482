// What a candidate will do, roughly, before anybody waits for it: the same scene on a few cells.
#ifndef PHYSMAS_BIND_COARSE_MOTION_H
#define PHYSMAS_BIND_COARSE_MOTION_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bind/problem.h"
#include "records/rollout.h"

namespace physmas::bind {

struct CoarseMotion {
  int cells = 0;  // of the grid, per axis
  long long steps = 0;
  // [Q] the companion's particles at rest, solver space, and the inventory row of each.
  std::vector<Eigen::Vector3f> rest;
  std::vector<int32_t> row;
  std::vector<double> times;         // [T] s, the rest frame first
  std::vector<RolloutFrame> frames;  // [T] of Q particles; F is the total deformation gradient
  double asked = 0;                  // s of the whole run
  std::string reason;                // why it ends before `asked`: "budget", or as mpm::Result has it; else empty
};

// Simulates a companion (mpm/companion.h) of about kCoarseCells cells per axis and keeps at most `pictures` frames,
// evenly spaced, and the last one. adaptive: with steps that follow the state; else with the candidate's own, longer as
// the cells are. The work is bounded, whatever the scene: what would take longer ends earlier. On the CPU, so that the
// same scene gives the same motion whatever the machine has. Errors as bind_problem has them.
CoarseMotion coarse_motion(const Candidate& candidate, const State& state, const RunSpecification& run,
                           const ProblemFiles& files, int pictures, bool adaptive);

constexpr int kCoarseCells = 25;

}  // namespace physmas::bind

#endif
