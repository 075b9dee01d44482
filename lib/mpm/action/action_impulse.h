// A short particle-force impulse (paper, Table "actions": impulse).
#ifndef PHYSMAS_MPM_ACTION_ACTION_IMPULSE_H
#define PHYSMAS_MPM_ACTION_ACTION_IMPULSE_H

#include <vector>

#include "mpm/action/control.h"
#include "mpm/action/region.h"

namespace physmas::mpm {

// A force that changes the velocity of every particle of the rows by `velocity_change` in all, spread evenly over
// [start, start + duration]. The duration is at most four base substeps, whatever the substep in use.
struct Impulse {
  std::vector<int> rows;
  Vec3d velocity_change = {0, 0, 0};  // m/s
  double start = 0;                   // s
  double duration = 8e-4;             // s, > 0
  double base_step = 2e-4;            // the base substep Δt₀ [s]

  double end() const { return start + (duration < 4 * base_step ? duration : 4 * base_step); }
};

// As in action_velocity.h. Substeps that cover the interval in part get their share, so the total does not depend on
// dt.
Region select_region(const Impulse& action, const Particles& rest);
void add_control(const Impulse& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
