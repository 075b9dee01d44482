// Impacts of rigid bodies: for some substeps they deform as their material does, in smaller steps, and everything else
// with them. What they rebound with follows from that and is remembered for impacts that the budget does not cover.
#ifndef PHYSMAS_MPM_RIGID_IMPACT_WINDOWS_H
#define PHYSMAS_MPM_RIGID_IMPACT_WINDOWS_H

#include "mpm/stepper.h"

namespace physmas::mpm {

struct ImpactHistory {
  long long windows = 0;
  long long steps = 0;        // substeps that lay in windows
  long long small_steps = 0;  // that they took
};

class ImpactWindows {
 public:
  // Small steps are no more than `budget` per substep so far, and about two windows that are free; below 0:
  // none at all. mass [kg]: of all
  // particles, whose weight at most is what rest contact carries.
  ImpactWindows(double budget, double mass) : budget_(budget), mass_(mass) {}

  // What actions do in [time, time + dt), time from the start of the call [s].
  using TimedControls = std::function<bool(double time, double dt, std::vector<Control>& out)>;
  // As Stepper::advance, which has rigid bodies.
  StepReport advance(Stepper& stepper, int steps, double dt, const TimedControls& controls, double energy_limit);

  bool open() const { return open_; }
  const ImpactHistory& history() const { return history_; }

 private:
  bool quiet(const RigidMotion& rigid, const std::vector<Vec3d>& impulse, const Vec3d& gravity, double dt);

  double budget_, mass_;
  bool open_ = false, hit_ = false;
  int age_ = 0;  // substeps since the window opened
  std::vector<double> pushed_;
  long long done_ = 0;
  ImpactHistory history_;
};

}  // namespace physmas::mpm

#endif
