#include "mpm/action/action_spread.h"

namespace physmas::mpm {

Region select_region(const RadialSpread& action, const Particles& rest) {
  return select_slab(action.rows, action.up, 1, rest);
}

void add_control(const RadialSpread& action, const Region& region, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt) || !(region.radius > 0)) return;
  Control field;
  field.axis = (1 / norm(action.up)) * action.up;
  field.center = region.center;
  const double rate = action.speed / region.radius;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) field.gradient[a][b] = rate * ((a == b) - field.axis[a] * field.axis[b]);
  }
  field.speed_limit = action.speed;
  field.blend.across = blend_weight(dt, action.blend_time);
  field.position.across = action.position;
  follow(field, control);
}

}  // namespace physmas::mpm
