// The two branches without yield, Jelly and Metal: Kirchhoff stress τ = P Fᵀ [Pa of the rest volume] and energy.
//
// Both return finite values for every finite F: F with an entry beyond kDeformationCap is scaled down to it; Jelly's
// energy is continued linearly in J below kStretchFloor, so that a collapsed or inverted element is pushed back; Metal
// is polynomial in F and R, with R always a proper rotation.
#ifndef PHYSMAS_MPM_MATERIAL_HYPERELASTIC_H
#define PHYSMAS_MPM_MATERIAL_HYPERELASTIC_H

#include "mpm/math/isotropic.h"
#include "mpm/math/svd.h"

namespace physmas::mpm {

constexpr double kStretchFloor = 0.05;
constexpr double kDeformationCap = 1e3;

template <class T>
PHYSMAS_INLINE Mat3<T> cap_deformation(const Mat3<T>& F) {
  const T cap(static_cast<Scalar<T>>(kDeformationCap));
  const T largest = largest_entry(F);
  return select(largest > cap, cap / at_least(largest, cap), T(1)) * F;
}

// Whether all stretches lie well inside the range in which the polynomials of b = F Fᵀ hold and no law is continued:
// above the floor, not inverted, no entry of F beyond the cap.
template <class T>
PHYSMAS_INLINE auto ordinary_stretch(const Deviation<T>& b, const T& J) {
  constexpr double kLow = 1.1 * kStretchFloor * kStretchFloor / (1 - kDeviationRange<T>);
  constexpr double kHigh = 0.3 * kDeformationCap * kDeformationCap;
  return J > T(0) && b.mean > T(static_cast<Scalar<T>>(kLow)) && b.mean < T(static_cast<Scalar<T>>(kHigh)) &&
         in_range(b);
}

// ---- Jelly: compressible neo-Hookean, Ψ = μ/2 (g(J) tr b − 3) + U(J), b = F Fᵀ, g = J^(−2/3), U' = κ/2 (J − 1/J).

template <class T>
struct JellyTerms {
  T g, dg;  // g(J), g'(J)
  T dU;     // U'(J) / κ
};

// Below the floor J0, g and U are continued by their tangents.
template <class T>
PHYSMAS_INLINE JellyTerms<T> jelly_terms(const T& J) {
  const T floor(static_cast<Scalar<T>>(kStretchFloor));
  const T Jc = at_least(J, floor);
  const T root = inverse_cube_root(Jc);
  const T g = root * root;
  const T inverse = g * root;
  const T dg = Scalar<T>(-2.0 / 3.0) * g * inverse;
  return {g + (J - Jc) * dg, dg, Scalar<T>(0.5) * (Jc - inverse)};
}

// τ = μ (g b + g' J/2 tr(b) I) + κ U' J I; above the floor that is μ J^(−2/3) dev b + κ/2 (J² − 1) I.
template <class T>
PHYSMAS_INLINE Mat3<T> jelly_stress(const Mat3<T>& F_any, const T& mu, const T& bulk) {
  Mat3<T> F = F_any;
  Mat3<T> b = times_transposed(F, F);
  const T cap(static_cast<Scalar<T>>(kDeformationCap));
  if (!all(trace(b) < cap * cap)) {  // no entry is beyond the cap unless the norm is
    F = cap_deformation(F_any);
    b = times_transposed(F, F);
  }
  const T J = determinant(F);
  const JellyTerms<T> j = jelly_terms(J);
  const T pressure = J * (Scalar<T>(0.5) * mu * j.dg * trace(b) + bulk * j.dU);
  Mat3<T> tau = (mu * j.g) * b;
  tau[0].x += pressure, tau[1].y += pressure, tau[2].z += pressure;
  return tau;
}

// Energy per rest volume [J/m^3].
template <class T>
PHYSMAS_INLINE T jelly_energy(const Mat3<T>& F_any, const T& mu, const T& bulk) {
  const Mat3<T> F = cap_deformation(F_any);
  const T J = determinant(F);
  const JellyTerms<T> j = jelly_terms(J);
  const T Jc = at_least(J, T(static_cast<Scalar<T>>(kStretchFloor)));
  const T U = Scalar<T>(0.25) * (Jc * Jc - T(1)) - Scalar<T>(0.5) * natural_log(Jc) + (J - Jc) * j.dU;
  return Scalar<T>(0.5) * mu * (j.g * squared_norm(F) - T(3)) + bulk * U;
}

// ---- Metal: fixed corotated (Stomakhin et al. 2012), Ψ = μ |F − R|² + λ/2 (J − 1)².

template <class T>
PHYSMAS_INLINE Mat3<T> metal_stress_by_rotation(const Mat3<T>& F_any, const T& mu, const T& lambda) {
  const Mat3<T> F = cap_deformation(F_any);
  const Mat3<T> R = polar_rotation(F);
  const T J = determinant(F);
  const T pressure = lambda * (J - T(1)) * J;
  Mat3<T> tau = (mu + mu) * times_transposed(F - R, F);
  tau[0].x += pressure, tau[1].y += pressure, tau[2].z += pressure;
  return tau;
}

// (F − R) Fᵀ = b − V with V = R Fᵀ = √b the left stretch: a polynomial of b where F is an ordinary stretch, the polar
// decomposition for the rest.
template <class T>
PHYSMAS_INLINE Mat3<T> metal_stress(const Mat3<T>& F, const T& mu, const T& lambda) {
  const Deviation<T> b = deviation(left_cauchy_green(F));
  const T J = determinant(F);
  // b − √b of b = m (I + A): m A − √m (√(I + A) − I), and m − √m on the diagonal.
  const Quadratic<T> root = root_of_one_plus(b);
  const T scale = square_root(b.mean), two_mu = mu + mu;
  const T pressure = lambda * (J - T(1)) * J;
  Mat3<T> tau = to_matrix(evaluate<T>({two_mu * (b.mean - scale - scale * root.c0) + pressure,
                                       two_mu * (b.mean - scale * root.c1), -(two_mu * (scale * root.c2))},
                                      b.A, b.A2));
  const auto ordinary = ordinary_stretch(b, J);
  if (!all(ordinary)) tau = select(ordinary, tau, metal_stress_by_rotation(F, mu, lambda));
  return tau;
}

template <class T>
PHYSMAS_INLINE T metal_energy(const Mat3<T>& F_any, const T& mu, const T& lambda) {
  const Mat3<T> F = cap_deformation(F_any);
  const T volume = determinant(F) - T(1);
  return mu * squared_norm(F - polar_rotation(F)) + Scalar<T>(0.5) * lambda * volume * volume;
}

}  // namespace physmas::mpm

#endif
