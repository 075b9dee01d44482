// What the actions of a candidate achieved on their targets, measured on the frames that the solver hands out.
#ifndef PHYSMAS_BIND_ACHIEVEMENT_H
#define PHYSMAS_BIND_ACHIEVEMENT_H

#include <map>
#include <string>
#include <vector>

#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/execution.h"

namespace physmas::bind {

// The longest side [m] of the box around these places; at least one.
double longest_side(const std::vector<mpm::Vec3d>& places);

// 1 for what has not moved, 0 for what has drifted by a tenth of the scene's longest side at rest [m] or more.
double stillness_share(double drift, double longest_side);

// What an action with a shortfall was asked, what it reached, and why: one line for a person.
std::string shortfall_line(const AchievedAction& action);

// An action's interval rarely ends at an output frame. It is measured at the last frame before its end, each particle
// carried on to the end with its velocity: so nothing of what comes after is measured, and the solver is left alone.
// What an impulse gives is measured at the first frame after it.
class AchievementMeter {
 public:
  // problem: what bind_problem makes of the candidate; read during this call only. up: unit. frame_dt: s.
  AchievementMeter(const Candidate& candidate, const mpm::Problem& problem, const mpm::Vec3d& up, double frame_dt);
  ~AchievementMeter();

  // Every frame of the run, from frame 0 on.
  void observe(const mpm::Frame& frame);

  // One entry per action of the schedule, in its order: what was measured at its end, or before the run ended if that
  // was earlier. An action that never began achieved nothing.
  std::vector<AchievedAction> result() const;

 private:
  struct Meter;
  std::vector<Meter> meters_;
  std::map<int, std::string> key_of_;  // by inventory row
};

}  // namespace physmas::bind

#endif
