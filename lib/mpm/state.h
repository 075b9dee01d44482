// Particles as the callers see them: one entry per particle in the callers' order, double precision, solver space.
#ifndef PHYSMAS_MPM_STATE_H
#define PHYSMAS_MPM_STATE_H

#include <cstddef>
#include <vector>

#include "mpm/material/material.h"
#include "mpm/math/mat3.h"

namespace physmas::mpm {

// The particles at rest.
struct Particles {
  std::vector<Vec3d> position;              // [N] m
  std::vector<double> volume;               // [N] rest volume [m^3], > 0
  std::vector<int> row;                     // [N] index into the materials
  std::vector<Vec3d> velocity;              // [N] m/s, or empty: at rest
  std::vector<Mat3d> deformation_gradient;  // [N] elastic F at the start, any finite matrix; or empty: identity
  // [N] each particle's own E, nu and rho, in the domain of Material, its branch ignored: the row's counts. Empty: all
  // have their row's.
  std::vector<Material> material;

  size_t size() const { return position.size(); }
};

// What changes with time.
struct State {
  std::vector<Vec3d> x;          // [N] position [m]
  std::vector<Vec3d> v;          // [N] velocity [m/s]
  std::vector<Mat3d> F;          // [N] elastic deformation gradient, after the return map
  std::vector<Mat3d> C;          // [N] APIC affine velocity map B of the paper [1/s]
  std::vector<Mat3d> total_F;    // [N] total deformation gradient, without return maps; empty unless it is tracked
  std::vector<double> strength;  // [N] current von Mises strength of plasticine [Pa]

  size_t size() const { return x.size(); }
};

}  // namespace physmas::mpm

#endif
