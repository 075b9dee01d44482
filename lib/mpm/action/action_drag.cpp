#include "mpm/action/action_drag.h"

#include "mpm/action/nearest.h"

namespace physmas::mpm {

Region select_region(const DragFollow& action, const Particles& rest) {
  Region region = select_slab(action.rows, {0, 0, 1}, 1, rest);
  if (std::isinf(action.distance)) return region;
  const std::vector<int> pullers = particles_of_rows(action.pullers, rest);
  const NearestAtRest nearest(rest, pullers);
  std::vector<int> near;
  for (const int i : region.particles) {
    if (nearest.squared_distance(rest.position[i]) <= action.distance * action.distance) near.push_back(i);
  }
  region.particles = std::move(near);
  return region;
}

void add_control(const DragFollow& action, const Region&, double time, double dt, Control& control) {
  if (!covers(action.start, action.end, time, dt)) return;
  Control field;
  field.velocity = action.velocity;
  field.blend.along = field.blend.across = blend_weight(dt, action.blend_time);
  follow(field, control);
}

}  // namespace physmas::mpm
