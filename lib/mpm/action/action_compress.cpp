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
  const bool presses = covers(action.start, action.end, time, dt);
  if (!presses && !(action.release > 0 && covers(action.end, action.end + action.release, time, dt))) return;
  const double per_second = (action.ratio - 1) / (action.end - action.start);
  const auto extent = [&](double t) {
    if (presses) return 1 + per_second * std::max(0.0, t - action.start);
    return 1 + (action.ratio - 1) * (1 - retreat_way(action.end, action.release, t));
  };
  // From the extents at both ends of the substep, so that they multiply to the ratio whatever the substep.
  const double rate = (extent(time + dt) / extent(time) - 1) / dt;
  Control field;
  field.axis = (1 / norm(action.up)) * action.up;
  field.center = region.extent.low * field.axis;
  for (int a = 0; a < 3; ++a) field.gradient[a] = (rate * field.axis[a]) * field.axis;
  field.blend.along = 1;
  if (presses) {
    field.speed_limit = action.speed_limit;
    follow(field, control);
  } else {
    // Twice the mean speed of the top is the fastest that a hand goes back.
    field.speed_limit = 2 * std::fabs(1 - action.ratio) * region.extent.length() / action.release;
    give_way(field, control);
  }
}

void add_control(const SideCompress& action, const Region& region, double time, double dt, Control& control) {
  Control field;
  field.axis = (1 / norm(action.direction)) * action.direction;
  const double wanted = (1 - action.ratio) * region.extent.length() / (action.end - action.start);
  field.velocity = std::min(wanted, action.speed_limit) * field.axis;
  let_back((action.end - action.start) * field.velocity, action.end, action.release, time, dt, control);
  if (!covers(action.start, action.end, time, dt)) return;
  field.speed_limit = action.speed_limit;
  field.blend.along = blend_weight(dt, action.blend_time);
  field.position.along = action.position;
  follow(field, control);
}

}  // namespace physmas::mpm
