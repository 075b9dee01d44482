// Rotation about an axis (paper, Table "actions": torque).
#ifndef PHYSMAS_MPM_ACTION_ACTION_TORQUE_H
#define PHYSMAS_MPM_ACTION_ACTION_TORQUE_H

#include <limits>
#include <vector>

#include "mpm/action/control.h"
#include "mpm/action/region.h"

namespace physmas::mpm {

// During [start, end) the slab of the rows at the end `axis` is drawn into the tangential field ω × (x − c), ω = rate ·
// axis, about the axis through its rest centre c; an enforced one about that through the centre of the layer where the
// slab meets the rest. The rate is lowered until the outermost particle moves no faster than
// `speed_limit`, and until what lies between the slab and the other end is not sheared by more than `strain_limit`.
// Motion along the axis is free. Over [end, end + release) the slab may turn back to where it began, no faster than a
// hand does.
struct Torque {
  std::vector<int> rows;
  Vec3d axis = {0, 0, 1};     // towards the slab's end, any length > 0
  double rate = 2;            // rad/s, counterclockwise as seen from that end
  double slab_fraction = 1;   // thickness over the rows' rest extent along `axis`; 1: all of the rows
  double speed_limit = 1.5;   // m/s, > 0
  double blend_time = 2e-3;   // s, > 0, as in action_spread.h
  double start = 0, end = 0;  // s
  double release = 0;         // s, 0: the hand vanishes at the end
  bool enforced = false;      // the slab moves with exactly the field across the axis, instead of being blended into it
  double strain_limit = std::numeric_limits<double>::infinity();  // angle × radius / length between the slabs
};

// The rate [rad/s] within the bounds; the region is the action's.
double bounded_rate(const Torque& action, const Region& region);

// As in action_velocity.h.
Region select_region(const Torque& action, const Particles& rest);
void add_control(const Torque& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
