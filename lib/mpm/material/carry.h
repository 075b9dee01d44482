// The deformation that carries a stress: constitutive.h the other way round.
#ifndef PHYSMAS_MPM_MATERIAL_CARRY_H
#define PHYSMAS_MPM_MATERIAL_CARRY_H

#include "mpm/material/branch.h"
#include "mpm/material/material.h"
#include "mpm/math/isotropic.h"

namespace physmas::mpm {

// No principal stretch of what carries a load is farther from 1 than this, up or down.
constexpr double kLargestCarriedStretch = 2;

struct Carried {
  Mat3d F;                // symmetric: a stretch without rotation
  Symmetric<double> tau;  // the Kirchhoff stress of F [Pa]
  bool limited;           // whether tau is less than what was asked for
};

// F of a particle at rest whose stress is `tau` [Pa], or as near to it as the branch bears: Foam, Plasticine and Sand
// up to their yield (so that no return map moves F), Snow up to its stress cone, and none beyond
// kLargestCarriedStretch. A stress whose norm overflows is not borne at all.
Carried carry_stress(Branch branch, const MaterialParameters<double>& parameters, const Symmetric<double>& tau);

}  // namespace physmas::mpm

#endif
