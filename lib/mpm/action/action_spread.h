// Spreading outwards (paper, Table "actions": radial_spread).
#ifndef PHYSMAS_MPM_ACTION_ACTION_SPREAD_H
#define PHYSMAS_MPM_ACTION_ACTION_SPREAD_H

#include <vector>

#include "mpm/action/control.h"
#include "mpm/action/region.h"

namespace physmas::mpm {

// During [start, end) the rows' particles are drawn into the field speed/R · (x − axis), across `up` only: R is their
// largest rest distance from the axis through their centre, so the outermost move at `speed` and none is driven
// faster. Falling and rising stay free.
struct RadialSpread {
  std::vector<int> rows;
  Vec3d up = {0, 0, 1};       // any length > 0
  double speed = 0.3;         // m/s
  double blend_time = 2e-3;   // s, > 0: 63 % of a difference in velocity is gone after it
  double position = 0.1;      // 0..1: share of the field in the motion of places, the rest being the velocity's
  double start = 0, end = 0;  // s
};

// As in action_velocity.h.
Region select_region(const RadialSpread& action, const Particles& rest);
void add_control(const RadialSpread& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
