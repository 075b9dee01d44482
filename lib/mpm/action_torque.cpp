#include "mpm/action_torque.h"

namespace physmas::mpm {

Region select_region(const Torque& action, const Particles& rest) {
  return select_slab(action.rows, action.towards, action.slab_fraction, rest);
}

void add_control(const Torque& action, const Region& region, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  const Vec3d& w = action.angular_velocity;
  Control field;
  field.axis = (1 / norm(w)) * w;
  field.center = region.center;
  field.gradient = {{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}}};
  field.speed_limit = action.speed_limit;
  field.blend.across = blend_weight(dt, action.blend_time);
  follow(field, control);
}

}  // namespace physmas::mpm
