// Yield of the Hencky branches. An isotropic return map keeps the principal directions and shrinks the strain radially,
// so two numbers describe it: the mean that a principal triple gets and what is kept of its deviator.
#ifndef PHYSMAS_MPM_MATERIAL_PLASTICITY_H
#define PHYSMAS_MPM_MATERIAL_PLASTICITY_H

#include "base/constants.h"
#include "mpm/material/material.h"
#include "mpm/math/real.h"

namespace physmas::mpm {

// value_i → mean + keep (value_i − old mean), for principal strains or stresses. size: of the deviator that is left, so
// that who needs it need not wait for the division behind `keep`.
template <class T>
struct Radial {
  T mean, keep, size;
};

// Drucker–Prager stress cone |dev τ| <= max(0, k − α tr τ). Beyond the apex the hydrostatic tension is cut to k/α, so
// the result is always on or inside the cone. mean: tr τ / 3; size: |dev τ|.
template <class T>
PHYSMAS_INLINE Radial<T> project_to_cone(const T& mean, const T& size, const MaterialParameters<T>& p) {
  const T cut = at_most(mean, p.apex);
  const T limit = at_least(p.cohesion - Scalar<T>(3) * (p.alpha * cut), T(0));
  return {cut, select(size > limit, limit / at_least(size, T(kTiny<T>)), T(1)), at_most(size, limit)};
}

// Sand's return map (Klar et al. 2016, without their volume correction): tension returns to the apex (no strain),
// anything else to the cone along the deviator. mean, size: of the logarithmic strain; inverse: 1 / size. `moved`:
// where it changes.
template <class T, class Condition>
PHYSMAS_INLINE Radial<T> sand_return(const T& mean, const T& size, const T& inverse, const MaterialParameters<T>& p,
                                     Condition& moved) {
  const T limit = at_least(Scalar<T>(-3) * p.strain_friction * mean, T(0));
  const auto tension = mean > T(0);
  const auto outside = size > limit;
  const T keep = select(outside, limit * inverse, T(1));
  moved = tension || outside;
  return {select(tension, T(0), mean), select(tension, T(0), keep), select(tension, T(0), at_most(size, limit))};
}

// Foam's viscoplastic return map for StVK–Hencky (Yue et al. 2015): beyond |dev τ| = sqrt(2/3) yield the stress relaxes
// towards the yield surface at a rate set by the viscosity (0: at once). trace_b: tr b of the trial state; dt: [s].
template <class T, class Condition>
PHYSMAS_INLINE Radial<T> foam_return(const T& mean, const T& size, const T& inverse, const T& trace_b,
                                     const MaterialParameters<T>& p, const T& dt, Condition& moved) {
  const T two_mu = p.mu + p.mu;
  const T limit = Scalar<T>(kRootTwoThirds) * p.yield * p.inverse_mu;
  moved = size > limit;
  const T stiffness = two_mu * Scalar<T>(1.0 / 3.0) * trace_b * dt;
  const T rate = stiffness / at_least(stiffness + p.viscosity, T(kTiny<T>));
  const T keep = select(moved, T(1) - rate * (T(1) - limit * inverse), T(1));
  return {mean, keep, keep * size};
}

// Plasticine's von Mises return map with damage: the strength falls by softening × |plastic strain increment|, never
// below the residual. `yield` is the particle's strength [Pa], updated.
template <class T, class Condition>
PHYSMAS_INLINE Radial<T> plasticine_return(const T& mean, const T& size, const T& inverse,
                                           const MaterialParameters<T>& p, T& yield, Condition& moved) {
  const T limit = Scalar<T>(kRootTwoThirds) * yield * p.inverse_mu;
  moved = size > limit;
  const T keep = select(moved, limit * inverse, T(1)), left = at_most(size, limit);
  yield = select(moved, at_least(yield - p.softening * (size - limit), at_most(p.residual_yield, yield)), yield);
  return {mean, keep, left};
}

// The return map of a branch; Snow has none. squared_size: of the strain's deviator. Other arguments as above.
template <class T, class Condition>
PHYSMAS_INLINE Radial<T> return_map(Branch branch, const MaterialParameters<T>& p, const T& mean, const T& squared_size,
                                    const T& trace_b, const T& dt, T& strength, Condition& moved) {
  // Root and division side by side, not one after the other.
  const T size = square_root(squared_size), inverse = size * (T(1) / at_least(squared_size, T(kTiny<T>)));
  if (branch == Branch::sand) return sand_return(mean, size, inverse, p, moved);
  if (branch == Branch::foam) return foam_return(mean, size, inverse, trace_b, p, dt, moved);
  if (branch == Branch::plasticine) return plasticine_return(mean, size, inverse, p, strength, moved);
  return {mean, T(1), size};
}

PHYSMAS_HOST_DEVICE constexpr bool has_return_map(Branch branch) {
  return branch == Branch::sand || branch == Branch::foam || branch == Branch::plasticine;
}

PHYSMAS_HOST_DEVICE constexpr bool has_stress_cone(Branch branch) {
  return branch == Branch::sand || branch == Branch::snow || branch == Branch::plasticine;
}

}  // namespace physmas::mpm

#endif
