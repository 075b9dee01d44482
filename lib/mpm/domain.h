// The box that is simulated: grid, gravity, walls and colliders. Solver space: the cube [0, length]^3, metres, seconds.
#ifndef PHYSMAS_MPM_DOMAIN_H
#define PHYSMAS_MPM_DOMAIN_H

#include <vector>

#include "mpm/math/mat3.h"

namespace physmas::mpm {

// A fixed obstacle. The grid velocity at every node on or inside it is changed by `mode`.
struct Collider {
  enum class Type { plane, box, sphere };
  enum class Mode {
    sticky,    // velocity becomes zero
    slip,      // the normal part is removed in both directions
    separate,  // only the part that points into the collider is removed
  };
  Type type = Type::plane;
  Mode mode = Mode::separate;
  double friction = 0;          // Coulomb coefficient, >= 0; acts where material is pressed in (slip, separate)
  Vec3d center = {0, 0, 0};     // a point of the plane; the centre of the box or sphere
  Vec3d normal = {0, 0, 1};     // plane: out of the solid half-space, any length > 0
  Vec3d half_size = {0, 0, 0};  // box: half of its edges, along the axes
  double radius = 0;            // sphere
};

struct Domain {
  int n = 100;                   // cells per axis, at least 8; n + 1 nodes
  double length = 2;             // edge [m]
  Vec3d gravity = {0, 0, -9.8};  // [m/s^2]
  int wall_cells = 3;            // nodes this close to the boundary let no velocity out; at least 2
  std::vector<Collider> colliders;

  double dx() const { return length / n; }
};

}  // namespace physmas::mpm

#endif
