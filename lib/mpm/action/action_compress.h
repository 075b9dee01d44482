// Compression from above and from a side (paper, Table "actions": vertical_compress, side_compress).
#ifndef PHYSMAS_MPM_ACTION_ACTION_COMPRESS_H
#define PHYSMAS_MPM_ACTION_ACTION_COMPRESS_H

#include <vector>

#include "mpm/action/control.h"
#include "mpm/action/region.h"

namespace physmas::mpm {

// During [start, end) heights above the rows' lowest rest height h₀ shrink to `ratio` of what they were:
// h(t) = h₀ + (1 − (1 − ratio) s) (h − h₀), s from 0 to 1. That motion is enforced along `up`, no faster than
// `speed_limit`; across it the particles are free, so that material can give way to the sides. Over [end, end +
// release) heights may grow back to what they were, no faster than a hand goes.
struct VerticalCompress {
  std::vector<int> rows;
  Vec3d up = {0, 0, 1};       // any length > 0
  double ratio = 0.6;         // final over rest extent, > 0
  double speed_limit = 0.5;   // m/s
  double start = 0, end = 0;  // s
  double release = 0;         // s, 0: the hand vanishes at the end
};

// During [start, end) the slab that `direction` meets first moves inwards with a bounded force: by 1 − ratio of the
// rows' rest extent along `direction` in all, as far as the material yields. Only motion along `direction` is blended.
// Over [end, end + release) the slab is let back to where it began, no faster than a hand goes.
struct SideCompress {
  std::vector<int> rows;
  Vec3d direction = {1, 0, 0};  // inwards, any length > 0
  double ratio = 0.7;           // final over rest extent, 0..1
  double slab_fraction = 0.15;  // of the rows' rest extent along `direction`
  double speed_limit = 0.5;     // m/s
  double blend_time = 5e-4;     // s, > 0, as in action_spread.h
  double position = 0.1;        // 0..1, as in action_spread.h
  double start = 0, end = 0;    // s
  double release = 0;           // s, as above
};

// As in action_velocity.h.
Region select_region(const VerticalCompress& action, const Particles& rest);
Region select_region(const SideCompress& action, const Particles& rest);
void add_control(const VerticalCompress& action, const Region& region, double time, double dt, Control& control);
void add_control(const SideCompress& action, const Region& region, double time, double dt, Control& control);

}  // namespace physmas::mpm

#endif
