// Contact of grid velocities with colliders.
#ifndef PHYSMAS_MPM_ACTION_COLLIDER_H
#define PHYSMAS_MPM_ACTION_COLLIDER_H

#include "mpm/domain.h"

namespace physmas::mpm {

// Signed distance [m] of `x` to the collider's surface, negative inside, and the outward unit normal there.
struct Contact {
  double distance;
  Vec3d normal;
};

namespace contact_detail {

PHYSMAS_INLINE Contact locate_in_box(const Collider& c, const Vec3d& x) {
  const Vec3d d = x - c.center;
  Vec3d beyond{}, normal{0, 0, 0};
  for (int i = 0; i < 3; ++i) beyond[i] = std::fabs(d[i]) - c.half_size[i];
  if (beyond.x <= 0 && beyond.y <= 0 && beyond.z <= 0) {
    int face = 0;
    for (int i = 1; i < 3; ++i)
      if (beyond[i] > beyond[face]) face = i;
    normal[face] = d[face] < 0 ? -1 : 1;
    return {beyond[face], normal};
  }
  Vec3d outside{};
  for (int i = 0; i < 3; ++i) outside[i] = beyond[i] > 0 ? (d[i] < 0 ? -beyond[i] : beyond[i]) : 0;
  const double distance = norm(outside);
  return {distance, (1 / distance) * outside};
}

}  // namespace contact_detail

PHYSMAS_CALL inline Contact locate(const Collider& c, const Vec3d& x) {
  if (c.type == Collider::Type::box) return contact_detail::locate_in_box(c, x);
  if (c.type == Collider::Type::plane) {
    const Vec3d n = (1 / norm(c.normal)) * c.normal;
    return {dot(x - c.center, n), n};
  }
  const Vec3d d = x - c.center;
  const double distance = norm(d);
  // At the very centre of a sphere every direction is as good as any other.
  return {distance - c.radius, distance > 0 ? (1 / distance) * d : Vec3d{0, 0, 1}};
}

// The velocity [m/s] that a node with this contact keeps. Coulomb friction takes at most friction × (normal velocity
// removed) from the tangential speed (Stomakhin et al. 2013). Velocities of nodes outside are returned as they are.
PHYSMAS_CALL inline Vec3d apply_contact(const Collider& c, const Contact& contact, const Vec3d& u) {
  if (contact.distance > 0) return u;
  if (c.mode == Collider::Mode::sticky) return {0, 0, 0};
  const double normal_speed = dot(u, contact.normal);
  if (normal_speed >= 0 && c.mode == Collider::Mode::separate) return u;
  const Vec3d tangential = u - normal_speed * contact.normal;
  const double speed = norm(tangential);
  const double loss = c.friction * at_least(-normal_speed, 0.0);
  if (speed <= loss) return {0, 0, 0};
  return (1 - (speed > 0 ? loss / speed : 0)) * tangential;
}

// Whether a wall or a collider may touch one of the nodes of a block. first: its lowest node, [3]; nodes: per axis.
bool near_obstacle(const Domain& domain, const int* first, int nodes);

}  // namespace physmas::mpm

#endif
