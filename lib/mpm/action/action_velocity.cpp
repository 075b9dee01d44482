#include "mpm/action/action_velocity.h"

#include <algorithm>

namespace physmas::mpm {

Region select_region(const Translation& action, const Particles& rest) {
  return select_slab(action.rows, {0, 0, 1}, 1, rest);
}

Region select_region(const SlabMotion& action, const Particles& rest) {
  return select_slab(action.rows, action.towards, action.slab_fraction, rest);
}

Region select_region(const ScaleSlab& action, const Particles& rest) {
  return select_slab(action.rows, action.axis, action.slab_fraction, rest);
}

void add_control(const Translation& action, const Region&, double time, double dt, Control& control) {
  if (covers(action.start, action.end, time, dt)) enforce(action.velocity, control);
}

void add_control(const SlabMotion& action, const Region&, double time, double dt, Control& control) {
  if (covers(action.start, action.end, time, dt)) enforce(action.velocity, control);
  let_back((action.end - action.start) * action.velocity, action.end, action.release, time, dt, control);
}

void add_control(const ScaleSlab& action, const Region& region, double time, double dt, Control& control) {
  const double wanted = 0.5 * (action.ratio - 1) * region.extent.length() / (action.end - action.start);
  const double speed = std::max(-action.speed_limit, std::min(wanted, action.speed_limit));
  const Vec3d velocity = (speed / norm(action.axis)) * action.axis;
  if (covers(action.start, action.end, time, dt)) enforce(velocity, control);
  let_back((action.end - action.start) * velocity, action.end, action.release, time, dt, control);
}

}  // namespace physmas::mpm
