// The six constitutive branches (paper, Table "constitutive"): Kirchhoff stress τ = P Fᵀ [Pa of the rest volume], the
// plastic update of F where there is one, and the elastic energy. Templates on the real type (float, double or SIMD
// lanes), without branches on data but for rare exceptions, so that one text serves the scalar reference, the CPU
// kernels and a GPU. Every function returns finite values for every finite F: hyperelastic.h and hencky.h say how.
#ifndef PHYSMAS_MPM_MATERIAL_CONSTITUTIVE_H
#define PHYSMAS_MPM_MATERIAL_CONSTITUTIVE_H

#include "mpm/material/hencky.h"
#include "mpm/material/hyperelastic.h"

namespace physmas::mpm {

// One step of one branch: updates F (and the strength of plasticine) and returns the Kirchhoff stress.
// p: parameters; strength: current von Mises strength of plasticine [Pa], untouched by the others; dt: [s].
template <class T>
PHYSMAS_INLINE Mat3<T> update_branch(Branch branch, const MaterialParameters<T>& p, const T& dt, Mat3<T>& F,
                                     T& strength) {
  if (branch == Branch::jelly) return jelly_stress(F, p.mu, p.bulk);
  if (branch == Branch::metal) return metal_stress(F, p.mu, p.lambda);
  return update_hencky(branch, p, dt, F, strength);
}

// The Kirchhoff stress [Pa] of an F that has been through the return map; by singular values where it is a function of
// the principal stretches.
template <class T>
PHYSMAS_HOST_DEVICE inline Mat3<T> branch_stress(Branch branch, const MaterialParameters<T>& p, const Mat3<T>& F) {
  if (branch == Branch::jelly) return jelly_stress(F, p.mu, p.bulk);
  if (branch == Branch::metal) return metal_stress_by_rotation(F, p.mu, p.lambda);
  const Stretches<T> q = stretches(F);
  Vec3<T> tau = hencky_principal(q.strain, p.mu, p.lambda);
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] * q.inside[i];
  return from_principal(q.svd.U, has_stress_cone(branch) ? project_to_cone(tau, p) : tau);
}

// Elastic energy per rest volume [J/m^3]. For Sand, Snow and Plasticine it is the energy of the Hencky trial stress:
// the stress cone has no potential of its own.
template <class T>
PHYSMAS_HOST_DEVICE inline T branch_energy(Branch branch, const MaterialParameters<T>& p, const Mat3<T>& F) {
  if (branch == Branch::jelly) return jelly_energy(F, p.mu, p.bulk);
  if (branch == Branch::metal) return metal_energy(F, p.mu, p.lambda);
  return hencky_energy(F, p.mu, p.lambda);
}

// Whether the stress is the gradient of an energy: not where the stress cone cuts it.
PHYSMAS_HOST_DEVICE constexpr bool has_potential(Branch branch) {
  return branch == Branch::jelly || branch == Branch::metal || branch == Branch::foam;
}

// Whether a branch takes functions of the principal stretches: by polynomials of F Fᵀ, or by singular values of F where
// those end.
PHYSMAS_HOST_DEVICE constexpr bool needs_principal_stretches(Branch branch) {
  return branch != Branch::jelly;
}

}  // namespace physmas::mpm

#endif
