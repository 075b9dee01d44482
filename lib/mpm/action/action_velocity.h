// Actions that enforce a constant velocity on particles (paper, Table "actions": translation, top_press, scale,
// support_hold, and the puller of drag_pair).
#ifndef PHYSMAS_MPM_ACTION_ACTION_VELOCITY_H
#define PHYSMAS_MPM_ACTION_ACTION_VELOCITY_H

#include <vector>

#include "mpm/action/control.h"
#include "mpm/action/region.h"

namespace physmas::mpm {

// Every particle of the rows moves with `velocity` during [start, end).
struct Translation {
  std::vector<int> rows;
  Vec3d velocity = {0, 0, 0};  // m/s
  double start = 0, end = 0;   // s
};

// The slab of the rows at one end of them at rest moves with `velocity` during [start, end). A top_press has `towards`
// up and a velocity against it; a support_hold has velocity 0. A press ends as a hand's does: over [end, end + release)
// the hand goes back along `velocity` to where it began, and the slab may not overtake it; so it springs back no
// faster.
struct SlabMotion {
  std::vector<int> rows;
  Vec3d velocity = {0, 0, 0};   // m/s
  Vec3d towards = {0, 0, 1};    // the end, any length > 0
  double slab_fraction = 0.15;  // slab thickness over the rows' rest extent along `towards`, 0..1
  double start = 0, end = 0;    // s
  double release = 0;           // s, 0: the hand vanishes at the end
};
using TopPress = SlabMotion;

// One of the two slabs of a scale; the other has the opposite axis. It moves along `axis` so fast that both together
// bring the rows' extent to `ratio` times its rest value at `end`, but never faster than `speed_limit`. Over [end, end
// + release) the slab is let back to where it began, no faster than a hand goes.
struct ScaleSlab {
  std::vector<int> rows;
  Vec3d axis = {1, 0, 0};       // towards the slab, any length > 0
  double ratio = 1;             // final over rest extent, > 0
  double slab_fraction = 0.15;  // as SlabMotion
  double speed_limit = 1;       // m/s
  double start = 0, end = 0;    // s
  double release = 0;           // s, as SlabMotion
};

// The particles that an action moves; chosen at rest, once.
Region select_region(const Translation& action, const Particles& rest);
Region select_region(const SlabMotion& action, const Particles& rest);
Region select_region(const ScaleSlab& action, const Particles& rest);

// Adds what the action does in the substep [time, time + dt) to `control`.
void add_control(const Translation& action, const Region& region, double time, double dt, Control& control);
void add_control(const SlabMotion& action, const Region& region, double time, double dt, Control& control);
void add_control(const ScaleSlab& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
