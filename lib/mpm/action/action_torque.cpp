#include "mpm/action/action_torque.h"

namespace physmas::mpm {

Region select_region(const Torque& action, const Particles& rest) {
  return select_slab(action.rows, action.axis, action.slab_fraction, rest);
}

void add_control(const Torque& action, const Region& region, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  Control field;
  field.axis = (1 / norm(action.axis)) * action.axis;
  // The outermost particle sets the rate, so that a bounded rotation is still that of a rigid body.
  const double fastest = std::fabs(action.rate) * region.radius;
  const Vec3d w = (fastest > action.speed_limit ? action.speed_limit / fastest : 1) * action.rate * field.axis;
  field.center = region.center;
  field.gradient = {{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}}};
  field.speed_limit = action.speed_limit;
  field.blend.across = blend_weight(dt, action.blend_time);
  follow(field, control);
}

}  // namespace physmas::mpm
