// What is dragged (paper, Table "actions": the follow flags of drag_pair). The puller itself is a Translation, or a
// SlabMotion where a thing is pulled by its own leading end.
#ifndef PHYSMAS_MPM_ACTION_ACTION_DRAG_H
#define PHYSMAS_MPM_ACTION_ACTION_DRAG_H

#include <limits>
#include <vector>

#include "mpm/action/control.h"
#include "mpm/action/region.h"

namespace physmas::mpm {

// During [start, end) particles of `rows` are drawn along with `velocity`: those that lie within `distance` of a
// particle of `pullers` at rest (interface), or all of them (whole target).
struct DragFollow {
  std::vector<int> rows, pullers;
  Vec3d velocity = {0, 0, 0};                                 // m/s
  double distance = std::numeric_limits<double>::infinity();  // m; infinite: the whole target
  double blend_time = 2e-3;                                   // s, > 0, as in action_spread.h
  double start = 0, end = 0;                                  // s
};

// As in action_velocity.h.
Region select_region(const DragFollow& action, const Particles& rest);
void add_control(const DragFollow& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
