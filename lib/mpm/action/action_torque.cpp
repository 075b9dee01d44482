#include "mpm/action/action_torque.h"

namespace physmas::mpm {

namespace {

constexpr double kJoint = 0.25;  // of the slab's thickness: the layer where it meets the rest

// Turns the region about where it meets the rest: a neck that leans would be dragged sideways, and torn off, by a turn
// about the centre of its head.
void move_to_joint(const Torque& action, const Particles& rest, Region& region) {
  const Vec3d axis = (1 / norm(action.axis)) * action.axis;
  const double border = region.extent.high - (1 - kJoint) * action.slab_fraction * region.extent.length();
  Vec3d sum{0, 0, 0};
  double count = 0;
  for (const int i : region.particles) {
    if (dot(axis, rest.position[i]) > border) continue;
    sum = sum + rest.position[i];
    ++count;
  }
  if (count == 0) return;
  region.center = (1 / count) * sum;
  region.radius = 0;
  for (const int i : region.particles)
    region.radius = std::fmax(region.radius, norm(cross(axis, rest.position[i] - region.center)));
}

}  // namespace

Region select_region(const Torque& action, const Particles& rest) {
  Region region = select_slab(action.rows, action.axis, action.slab_fraction, rest);
  if (action.enforced && action.slab_fraction < 1) move_to_joint(action, rest, region);
  return region;
}

double bounded_rate(const Torque& action, const Region& region) {
  // The outermost particle sets the rate, so that a bounded rotation is still that of a rigid body.
  const double fastest = std::fabs(action.rate) * region.radius;
  double share = fastest > action.speed_limit ? action.speed_limit / fastest : 1;
  // Two slabs and what lies between them.
  const double between = (1 - 2 * action.slab_fraction) * region.extent.length();
  const double strain = between > 0 ? fastest * (action.end - action.start) / between : 0;
  if (strain > action.strain_limit) share = std::fmin(share, action.strain_limit / strain);
  return share * action.rate;
}

void add_control(const Torque& action, const Region& region, double time, double dt, Control& control) {
  const bool turns = covers(action.start, action.end, time, dt);
  if (!turns && !(action.release > 0 && covers(action.end, action.end + action.release, time, dt))) return;
  Control field;
  field.axis = (1 / norm(action.axis)) * action.axis;
  double rate = bounded_rate(action, region);
  if (!turns) {
    const auto way = [&](double t) { return retreat_way(action.end, action.release, t); };
    rate *= -(action.end - action.start) * (way(time + dt) - way(time)) / dt;
  }
  const Vec3d w = rate * field.axis;
  field.center = region.center;
  field.gradient = {{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}}};
  if (turns) {
    field.speed_limit = action.speed_limit;
    field.blend.across = action.enforced ? 1 : blend_weight(dt, action.blend_time);
    follow(field, control);
  } else {
    // The slab's centre may have gone elsewhere, so the limit is not that of the radius at rest.
    field.speed_limit = 2 * std::fabs(rate) * region.radius;
    field.blend.across = 1;
    give_way(field, control);
  }
}

}  // namespace physmas::mpm
