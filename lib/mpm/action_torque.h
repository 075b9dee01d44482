// Rotation about an axis (paper, Table "actions": torque).
#ifndef PHYSMAS_MPM_ACTION_TORQUE_H
#define PHYSMAS_MPM_ACTION_TORQUE_H

#include <vector>

#include "mpm/control.h"
#include "mpm/region.h"

namespace physmas::mpm {

// During [start, end) the slab of the rows at the end `towards` is drawn into the tangential field ω × (x − c) about the
// axis through its rest centre c, no faster than `speed_limit`. Motion along the axis is free.
struct Torque {
  std::vector<int> rows;
  Vec3d angular_velocity = {0, 0, 2};  // rad/s, not zero
  Vec3d towards = {0, 0, 1};           // the slab's end, any length > 0
  double slab_fraction = 1;            // thickness over the rows' rest extent along `towards`; 1: all of them
  double speed_limit = 1.5;            // m/s
  double blend_time = 2e-3;            // s, > 0, as in action_spread.h
  double start = 0, end = 0;           // s
};

// As in action_velocity.h.
Region select_region(const Torque& action, const Particles& rest);
void add_control(const Torque& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
