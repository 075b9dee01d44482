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
Contact locate(const Collider& collider, const Vec3d& x);

// The velocity [m/s] that a node with this contact keeps. Coulomb friction takes at most friction × (normal velocity
// removed) from the tangential speed (Stomakhin et al. 2013). Velocities of nodes outside are returned as they are.
Vec3d apply_contact(const Collider& collider, const Contact& contact, const Vec3d& velocity);

}  // namespace physmas::mpm

#endif
