// Contact between bodies: each moves with a velocity field of its own on the shared grid, and where fields of several
// have mass at a node they push each other, but do not hold on to each other.
//
// One velocity field for everything, as the paper has it, glues whatever comes within two cells of each other. The
// fields of Bardenhagen, Brackbill and Sulsky ("The material-point method for granular materials", 2000) part again.
#ifndef PHYSMAS_MPM_BODY_CONTACT_H
#define PHYSMAS_MPM_BODY_CONTACT_H

#include <vector>

#include "mpm/math/mat3.h"

namespace physmas::mpm {

// What has its own field; further bodies share the last one.
constexpr int kMostBodies = 8;

struct BodyContact {
  std::vector<int> body;  // per row: 0 .. kMostBodies - 1; empty: all rows are one body
  double friction = 0;    // Coulomb coefficient, >= 0

  int of(int row) const { return body.empty() ? 0 : body[row]; }
  int bodies() const;
};

// A body at a node.
struct BodyAtNode {
  double mass;        // kg, > 0
  Vec3d mass_per_dx;  // gradient of the grid's mass in kg per cell; points into the body
  Vec3d u;            // m/s
};

namespace contact_detail {

// A third body may be pushed by what two others have settled; some rounds come close to what satisfies all three.
constexpr int kRounds = 4;

PHYSMAS_INLINE void meet(BodyAtNode& a, BodyAtNode& b, double friction) {
  // From a into b. Of relative gradients, so that a dense body does not decide alone where the two touch.
  const Vec3d between = (1 / b.mass) * b.mass_per_dx - (1 / a.mass) * a.mass_per_dx;
  const double length = norm(between);
  const Vec3d approach = a.u - b.u;
  Vec3d lost = approach;  // bodies that lie in each other have no side to part to
  if (length > 0) {
    const Vec3d n = (1 / length) * between;
    const double closing = dot(approach, n);
    if (!(closing > 0)) return;
    const Vec3d sliding = approach - closing * n;
    const double speed = norm(sliding);
    lost = closing * n + (speed > friction * closing ? friction * closing / speed : 1) * sliding;
  }
  const double whole = a.mass + b.mass;
  a.u = a.u - (b.mass / whole) * lost;
  b.u = b.u + (a.mass / whole) * lost;
}

}  // namespace contact_detail

// What the velocities become where bodies meet: pairs that approach lose their relative normal velocity and, to Coulomb
// friction, tangential velocity; pairs that part keep theirs. Momentum is conserved, energy never grows.
PHYSMAS_CALL inline void meet(BodyAtNode* bodies, int count, double friction) {
  for (int round = 0; round < (count > 2 ? contact_detail::kRounds : 1); ++round) {
    for (int a = 0; a < count; ++a) {
      for (int b = a + 1; b < count; ++b) contact_detail::meet(bodies[a], bodies[b], friction);
    }
  }
}

}  // namespace physmas::mpm

#endif
