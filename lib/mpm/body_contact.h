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

// What the velocities become where bodies meet: pairs that approach lose their relative normal velocity and, to Coulomb
// friction, tangential velocity; pairs that part keep theirs. Momentum is conserved, energy never grows.
void meet(BodyAtNode* bodies, int count, double friction);

}  // namespace physmas::mpm

#endif
