// The six constitutive branches (paper, Table "constitutive"): Kirchhoff stress τ = P Fᵀ [Pa of the rest volume], the
// plastic update of F where there is one, and the elastic energy. Templates on the real type (float, double or SIMD
// lanes), without branches on data, so that one text serves the scalar reference, the CPU kernels and a GPU.
//
// Every function returns finite values for every finite F:
// - F with an entry beyond kDeformationCap is scaled down to it before stress is evaluated.
// - Jelly's energy is continued linearly in J below kStretchFloor, so a collapsed or inverted element is pushed back.
// - Metal is polynomial in F and R, with R always a proper rotation.
// - Hencky branches evaluate strains at s_i = max(s_i, kStretchFloor), where s.z < 0 marks inversion, and hold the
//   principal first Piola stress constant below the floor (Irving et al. 2004): τ_i is scaled by s_i / kStretchFloor,
//   so an inverted element is pulled back through zero. A plastic update writes the floored stretch into F.
#ifndef PHYSMAS_MPM_CONSTITUTIVE_H
#define PHYSMAS_MPM_CONSTITUTIVE_H

#include "mpm/material.h"
#include "mpm/svd.h"

namespace physmas::mpm {

constexpr double kStretchFloor = 0.05;
constexpr double kDeformationCap = 1e3;

template <class T>
PHYSMAS_INLINE Mat3<T> cap_deformation(const Mat3<T>& F) {
  const T cap(static_cast<Scalar<T>>(kDeformationCap));
  const T largest = largest_entry(F);
  return select(largest > cap, cap / at_least(largest, cap), T(1)) * F;
}

// ---- Jelly: compressible neo-Hookean, Ψ = μ/2 (g(J) tr b − 3) + U(J), b = F Fᵀ, g = J^(−2/3), U' = κ/2 (J − 1/J).

template <class T>
struct JellyTerms {
  T g, dg;  // g(J), g'(J)
  T U, dU;  // U(J) / κ, U'(J) / κ
};

// Below the floor J0, g and U are continued by their tangents.
template <class T>
PHYSMAS_INLINE JellyTerms<T> jelly_terms(const T& J) {
  const T floor(static_cast<Scalar<T>>(kStretchFloor));
  const T Jc = at_least(J, floor);
  const T logJ = natural_log(Jc);
  const T g = exponential(Scalar<T>(-2.0 / 3.0) * logJ);
  const T inverse = T(1) / Jc;
  const T dg = Scalar<T>(-2.0 / 3.0) * g * inverse;
  const T dU = Scalar<T>(0.5) * (Jc - inverse);
  const T U = Scalar<T>(0.25) * (Jc * Jc - T(1)) - Scalar<T>(0.5) * logJ;
  const T below = J - Jc;
  return {g + below * dg, dg, U + below * dU, dU};
}

// τ = μ (g b + g' J/2 tr(b) I) + κ U' J I; above the floor that is μ J^(−2/3) dev b + κ/2 (J² − 1) I.
template <class T>
PHYSMAS_INLINE Mat3<T> jelly_stress(const Mat3<T>& F_any, const T& mu, const T& bulk) {
  const Mat3<T> F = cap_deformation(F_any);
  const T J = determinant(F);
  const JellyTerms<T> j = jelly_terms(J);
  const Mat3<T> b = times_transposed(F, F);
  const T pressure = J * (Scalar<T>(0.5) * mu * j.dg * trace(b) + bulk * j.dU);
  Mat3<T> tau = (mu * j.g) * b;
  tau[0].x += pressure, tau[1].y += pressure, tau[2].z += pressure;
  return tau;
}

// Energy per rest volume [J/m^3].
template <class T>
PHYSMAS_INLINE T jelly_energy(const Mat3<T>& F_any, const T& mu, const T& bulk) {
  const Mat3<T> F = cap_deformation(F_any);
  const JellyTerms<T> j = jelly_terms(determinant(F));
  return Scalar<T>(0.5) * mu * (j.g * squared_norm(F) - T(3)) + bulk * j.U;
}

// ---- Metal: fixed corotated (Stomakhin et al. 2012), Ψ = μ |F − R|² + λ/2 (J − 1)².

template <class T>
PHYSMAS_INLINE Mat3<T> metal_stress(const Mat3<T>& F_any, const T& mu, const T& lambda) {
  const Mat3<T> F = cap_deformation(F_any);
  const Mat3<T> R = polar_rotation(F);
  const T J = determinant(F);
  const T pressure = lambda * (J - T(1)) * J;
  Mat3<T> tau = (mu + mu) * times_transposed(F - R, F);
  tau[0].x += pressure, tau[1].y += pressure, tau[2].z += pressure;
  return tau;
}

template <class T>
PHYSMAS_INLINE T metal_energy(const Mat3<T>& F_any, const T& mu, const T& lambda) {
  const Mat3<T> F = cap_deformation(F_any);
  const T volume = determinant(F) - T(1);
  return mu * squared_norm(F - polar_rotation(F)) + Scalar<T>(0.5) * lambda * volume * volume;
}

// ---- Hencky elasticity, Ψ = μ |ε|² + λ/2 (tr ε)² with ε the logarithms of the principal stretches.

template <class T>
PHYSMAS_INLINE T sum(const Vec3<T>& a) {
  return a.x + a.y + a.z;
}
// a minus its mean: the deviator of a principal tensor.
template <class T>
PHYSMAS_INLINE Vec3<T> deviator(const Vec3<T>& a) {
  const T mean = Scalar<T>(1.0 / 3.0) * sum(a);
  return {a.x - mean, a.y - mean, a.z - mean};
}

template <class T>
struct Stretches {
  Svd<T> svd;      // of the capped F
  Vec3<T> strain;  // log of the floored stretches
  Vec3<T> inside;  // s_i / max(s_i, floor): 1 in the ordinary range
};

template <class T>
PHYSMAS_INLINE Stretches<T> stretches(const Mat3<T>& F) {
  const T floor(static_cast<Scalar<T>>(kStretchFloor));
  Stretches<T> r;
  r.svd = svd(cap_deformation(F));
  for (int i = 0; i < 3; ++i) {
    const T s = at_least(r.svd.s[i], floor);
    r.strain[i] = natural_log(s);
    r.inside[i] = select(r.svd.s[i] < floor, r.svd.s[i] / s, T(1));
  }
  return r;
}

// Principal Kirchhoff stresses 2 μ ε_i + λ tr ε.
template <class T>
PHYSMAS_INLINE Vec3<T> hencky_principal(const Vec3<T>& strain, const T& mu, const T& lambda) {
  const T volumetric = lambda * sum(strain);
  Vec3<T> tau;
  for (int i = 0; i < 3; ++i) tau[i] = (mu + mu) * strain[i] + volumetric;
  return tau;
}

template <class T>
PHYSMAS_INLINE Mat3<T> hencky_stress(const Mat3<T>& F, const T& mu, const T& lambda) {
  const Stretches<T> q = stretches(F);
  Vec3<T> tau = hencky_principal(q.strain, mu, lambda);
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] * q.inside[i];
  return from_principal(q.svd.U, tau);
}

template <class T>
PHYSMAS_INLINE T hencky_energy(const Mat3<T>& F, const T& mu, const T& lambda) {
  const Stretches<T> q = stretches(F);
  const Vec3<T> tau = hencky_principal(q.strain, mu, lambda);
  const T volumetric = sum(q.strain);
  T energy = mu * dot(q.strain, q.strain) + Scalar<T>(0.5) * lambda * volumetric * volumetric;
  // Below the floor P_i = tau_i / floor is constant, so the energy goes on linearly in s_i.
  for (int i = 0; i < 3; ++i) energy += tau[i] * (q.inside[i] - T(1));
  return energy;
}

// ---- Plasticity on principal values.

// Drucker–Prager stress cone |dev τ| <= max(0, k − α tr τ). Beyond the apex the hydrostatic tension is cut to k/α, so
// the result is always on or inside the cone.
template <class T>
PHYSMAS_INLINE Vec3<T> project_to_cone(const Vec3<T>& tau, const T& alpha, const T& k) {
  const T apex = k / at_least(alpha, T(kTiny<T>));
  const T pressure_sum = at_most(sum(tau), apex);
  const Vec3<T> s = deviator(tau);
  const T size = norm(s);
  const T limit = at_least(k - alpha * pressure_sum, T(0));
  const T keep = select(size > limit, limit / at_least(size, T(kTiny<T>)), T(1));
  const T mean = Scalar<T>(1.0 / 3.0) * pressure_sum;
  return {mean + keep * s.x, mean + keep * s.y, mean + keep * s.z};
}

// Sand's return map (Klar et al. 2016, without their volume correction): tension returns to the apex (no strain),
// anything else to the cone along the deviator. `moved` reports lanes whose strain changed.
template <class T, class Condition>
PHYSMAS_INLINE Vec3<T> sand_return(const Vec3<T>& strain, const T& mu, const T& lambda, const T& friction,
                                   Condition& moved) {
  const T volumetric = sum(strain);
  const Vec3<T> e = deviator(strain);
  const T size = norm(e);
  // |dev τ| <= −friction tr τ, divided by 2 μ.
  const T limit = -friction * (lambda * Scalar<T>(3) + mu + mu) / (mu + mu) * volumetric;
  const auto tension = volumetric > T(0);
  const auto outside = size > limit;
  const T keep = select(outside, at_least(limit, T(0)) / at_least(size, T(kTiny<T>)), T(1));
  const T mean = select(tension, T(0), Scalar<T>(1.0 / 3.0) * volumetric);
  moved = tension || outside;
  const T kept = select(tension, T(0), keep);
  return {mean + kept * e.x, mean + kept * e.y, mean + kept * e.z};
}

// Foam's viscoplastic return map for StVK–Hencky (Yue et al. 2015): beyond |dev τ| = sqrt(2/3) yield the stress relaxes
// towards the yield surface at a rate set by the viscosity (0: at once).
template <class T, class Condition>
PHYSMAS_INLINE Vec3<T> foam_return(const Vec3<T>& strain, const T& mu, const T& yield, const T& viscosity, const T& dt,
                                   Condition& moved) {
  const T volumetric = sum(strain);
  const Vec3<T> e = deviator(strain);
  const T two_mu = mu + mu;
  const T size = two_mu * norm(e);
  const T excess = size - Scalar<T>(0.81649658092772603) * yield;
  moved = excess > T(0);
  T stretch_sum(0);  // tr b of the trial state
  for (int i = 0; i < 3; ++i) stretch_sum += exponential(strain[i] + strain[i]);
  const T stiffness = two_mu * Scalar<T>(1.0 / 3.0) * stretch_sum * dt;
  const T relaxed = size - excess * (stiffness / at_least(stiffness + viscosity, T(kTiny<T>)));
  const T keep = select(moved, relaxed / at_least(size, T(kTiny<T>)), T(1));
  const T mean = Scalar<T>(1.0 / 3.0) * volumetric;
  return {mean + keep * e.x, mean + keep * e.y, mean + keep * e.z};
}

// Plasticine's von Mises return map with damage: the strength falls by softening × |plastic strain increment|, never
// below the residual. `yield` is the particle's strength [Pa], updated.
template <class T, class Condition>
PHYSMAS_INLINE Vec3<T> plasticine_return(const Vec3<T>& strain, const T& mu, const T& softening, const T& residual,
                                         T& yield, Condition& moved) {
  const T volumetric = sum(strain);
  const Vec3<T> e = deviator(strain);
  const T size = norm(e);
  const T limit = Scalar<T>(0.81649658092772603) * yield / (mu + mu);
  moved = size > limit;
  const T keep = select(moved, limit / at_least(size, T(kTiny<T>)), T(1));
  yield = select(moved, at_least(yield - softening * (size - limit), at_most(residual, yield)), yield);
  const T mean = Scalar<T>(1.0 / 3.0) * volumetric;
  return {mean + keep * e.x, mean + keep * e.y, mean + keep * e.z};
}

// U diag(exp(strain)) Vᵀ where `moved`, F elsewhere (bit for bit).
template <class T, class Condition>
PHYSMAS_INLINE void write_back(const Condition& moved, const Stretches<T>& q, const Vec3<T>& strain, Mat3<T>& F) {
  if (!any(moved)) return;
  Mat3<T> scaled = q.svd.Vt;
  for (int i = 0; i < 3; ++i) scaled[i] = exponential(strain[i]) * scaled[i];
  F = select(moved, q.svd.U * scaled, F);
}

// ---- One step of one branch: updates F (and the strength of plasticine) and returns the Kirchhoff stress.
// p: parameters; strength: current von Mises strength of plasticine [Pa], untouched by the others; dt: [s].

template <class T>
inline Mat3<T> update_branch(Branch branch, const MaterialParameters<T>& p, const T& dt, Mat3<T>& F, T& strength) {
  if (branch == Branch::jelly) return jelly_stress(F, p.mu, p.bulk);
  if (branch == Branch::metal) return metal_stress(F, p.mu, p.lambda);
  const Stretches<T> q = stretches(F);
  Vec3<T> strain = q.strain;
  Vec3<T> inside = q.inside;
  decltype(p.mu > p.mu) moved = T(1) < T(0);
  if (branch == Branch::sand) strain = sand_return(q.strain, p.mu, p.lambda, p.friction, moved);
  if (branch == Branch::foam) strain = foam_return(q.strain, p.mu, p.yield, p.viscosity, dt, moved);
  if (branch == Branch::plasticine) {
    strain = plasticine_return(q.strain, p.mu, p.softening, p.residual_yield, strength, moved);
  }
  if (branch != Branch::snow) write_back(moved, q, strain, F);
  Vec3<T> tau = hencky_principal(strain, p.mu, p.lambda);
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] * select(moved, T(1), inside[i]);
  if (branch != Branch::foam) tau = project_to_cone(tau, p.alpha, p.cohesion);
  return from_principal(q.svd.U, tau);
}

// Elastic energy per rest volume [J/m^3]. For Sand, Snow and Plasticine it is the energy of the Hencky trial stress:
// the stress cone has no potential of its own.
template <class T>
inline T branch_energy(Branch branch, const MaterialParameters<T>& p, const Mat3<T>& F) {
  if (branch == Branch::jelly) return jelly_energy(F, p.mu, p.bulk);
  if (branch == Branch::metal) return metal_energy(F, p.mu, p.lambda);
  return hencky_energy(F, p.mu, p.lambda);
}

// Whether the stress is the gradient of an energy: not where the stress cone cuts it.
constexpr bool has_potential(Branch branch) {
  return branch == Branch::jelly || branch == Branch::metal || branch == Branch::foam;
}

constexpr bool needs_svd(Branch branch) {
  return branch != Branch::jelly;
}

}  // namespace physmas::mpm

#endif
