// Rows too stiff for the step, as the steppers see them: bodies that keep their shape.
#ifndef PHYSMAS_MPM_RIGID_RIGID_SETUP_H
#define PHYSMAS_MPM_RIGID_RIGID_SETUP_H

#include <vector>

#include "mpm/body_contact.h"
#include "mpm/math/mat3.h"

namespace physmas::mpm {

// Field 0 of the grid belongs to everything else.
constexpr int kMostRigidBodies = kMostBodies - 1;

// A body at rest. Its centre and its inertia are those of its particles' masses.
struct RigidBodyRest {
  std::vector<int> particles;  // ascending
  double mass = 0;             // kg
  Vec3d center = {0, 0, 0};    // m
  Mat3d inertia;               // kg m^2, about the centre; what the grid's weights add is in it: M dx^2/2 per axis
  double radius = 0;           // m, of the farthest particle
  double lock = 0;             // 1/s^2: the square of the highest frequency that the grid resolves, 4 a/(rho dx^2)
  double limit = 0;            // s: the largest stable step of its material
};

struct RigidSetup {
  std::vector<RigidBodyRest> bodies;
  std::vector<int> body_of_row;  // per row of the stepper: its body, -1: none; no row has particles of several
  std::vector<Vec3d> offset;     // per particle: from its body's centre, at rest [m]; zero for all others
  std::vector<Mat3d> F;          // per particle: elastic F at rest; empty: identity

  bool empty() const { return bodies.empty(); }
  int body_of(int row) const { return bodies.empty() ? -1 : body_of_row[row]; }
};

}  // namespace physmas::mpm

#endif
