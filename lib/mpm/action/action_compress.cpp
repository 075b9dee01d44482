#include "mpm/action/action_compress.h"

#include <algorithm>

namespace physmas::mpm {

Region select_region(const VerticalCompress& action, const Particles& rest) {
  return select_slab(action.rows, action.up, 1, rest);
}

Region select_region(const SideCompress& action, const Particles& rest) {
  return select_slab(action.rows, -action.direction, action.slab_fraction, rest);
}

void add_control(const VerticalCompress& action, const Region& region, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  const double per_second = (action.ratio - 1) / (action.end - action.start);
  const auto extent = [&](double t) { return 1 + per_second * std::max(0.0, t - action.start); };
  // From the extents at both ends of the substep, so that they multiply to the ratio whatever the substep.
  const double rate = (extent(time + dt) / extent(time) - 1) / dt;
  Control field;
  field.axis = (1 / norm(action.up)) * action.up;
  field.center = region.extent.low * field.axis;
  for (int a = 0; a < 3; ++a) field.gradient[a] = (rate * field.axis[a]) * field.axis;
  field.speed_limit = action.speed_limit;
  field.blend.along = 1;
  follow(field, control);
}

void add_control(const SideCompress& action, const Region& region, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  Control field;
  field.axis = (1 / norm(action.direction)) * action.direction;
  const double wanted = (1 - action.ratio) * region.extent.length() / (action.end - action.start);
  field.velocity = std::min(wanted, action.speed_limit) * field.axis;
  field.speed_limit = action.speed_limit;
  field.blend.along = blend_weight(dt, action.blend_time);
  field.position.along = action.position;
  follow(field, control);
}

}  // namespace physmas::mpm
