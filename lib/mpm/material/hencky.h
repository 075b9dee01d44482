// Hencky elasticity, Ψ = μ |ε|² + λ/2 (tr ε)² with ε the logarithms of the principal stretches, and one step of the
// four branches that stand on it.
//
// Strains are evaluated at s_i = max(s_i, kStretchFloor), where s.z < 0 marks inversion; below the floor the principal
// first Piola stress is held constant (Irving et al. 2004): τ_i is scaled by s_i / kStretchFloor, so an inverted
// element is pulled back through zero. A plastic update writes the floored stretch into F.
#ifndef PHYSMAS_MPM_MATERIAL_HENCKY_H
#define PHYSMAS_MPM_MATERIAL_HENCKY_H

#include "mpm/material/hyperelastic.h"
#include "mpm/material/plasticity.h"

namespace physmas::mpm {

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

// ---- By singular values: right for every F.

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

template <class T>
PHYSMAS_INLINE Vec3<T> apply(const Radial<T>& map, const Vec3<T>& a) {
  const Vec3<T> d = deviator(a);
  return {map.mean + map.keep * d.x, map.mean + map.keep * d.y, map.mean + map.keep * d.z};
}

// Principal stresses cut to the Drucker–Prager cone (plasticity.h).
template <class T>
PHYSMAS_INLINE Vec3<T> project_to_cone(const Vec3<T>& tau, const MaterialParameters<T>& p) {
  return apply(project_to_cone(Scalar<T>(1.0 / 3.0) * sum(tau), norm(deviator(tau)), p), tau);
}

// One step by singular values: updates F (where it yields; elsewhere it stays bit for bit) and the strength of
// plasticine, and returns the Kirchhoff stress. The reference for the polynomials below.
template <class T>
PHYSMAS_HOST_DEVICE inline Mat3<T> update_hencky_by_svd(Branch branch, const MaterialParameters<T>& p, const T& dt,
                                                        Mat3<T>& F, T& strength) {
  const Stretches<T> q = stretches(F);
  decltype(p.mu > p.mu) moved = T(1) < T(0);
  T trace_b(0);
  for (int i = 0; i < 3; ++i) trace_b += exponential(q.strain[i] + q.strain[i]);
  const Vec3<T> d = deviator(q.strain);
  const Radial<T> map =
      return_map(branch, p, Scalar<T>(1.0 / 3.0) * sum(q.strain), dot(d, d), trace_b, dt, strength, moved);
  const Vec3<T> strain = apply(map, q.strain);
  if (any(moved)) {
    Mat3<T> scaled = q.svd.Vt;
    for (int i = 0; i < 3; ++i) scaled[i] = exponential(strain[i]) * scaled[i];
    F = select(moved, q.svd.U * scaled, F);
  }
  Vec3<T> tau = hencky_principal(strain, p.mu, p.lambda);
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] * select(moved, T(1), q.inside[i]);
  if (has_stress_cone(branch)) tau = project_to_cone(tau, p);
  return from_principal(q.svd.U, tau);
}

// ---- As polynomials of tensors: every τ_i is a mean plus a multiple of the deviatoric strain, and the plastic update
// is F ← exp(ε' − ε) F.

// ε = mean I + deviator, with the square of the deviator's norm.
template <class T>
struct HenckyStrain {
  T mean, squared_size;
  Symmetric<T> deviator;
};

// log S of S = m (I + A), times `factor`.
template <class T>
PHYSMAS_INLINE HenckyStrain<T> logarithm(const Deviation<T>& S, Scalar<T> factor) {
  const Quadratic<T> c = log_of_one_plus(S);
  const T third = Scalar<T>(2.0 / 3.0) * (c.c2 * S.q);  // tr A² = 2 q
  const T c1 = factor * c.c1, c2 = factor * c.c2;
  HenckyStrain<T> e;
  e.mean = factor * (natural_log(S.mean) + (c.c0 + third));
  e.deviator = evaluate<T>({-(factor * third), c1, c2}, S.A, S.A2);
  // |c1 A + c2 (A² − 2/3 q I)|² with tr A³ = 3 r and tr A⁴ = 2 q².
  e.squared_size = (S.q + S.q) * (c1 * c1) + c2 * (Scalar<T>(6) * (S.r * c1) + Scalar<T>(2.0 / 3.0) * (S.q * S.q) * c2);
  e.squared_size = at_least(e.squared_size, T(0));
  return e;
}

template <class Condition, class T>
PHYSMAS_INLINE HenckyStrain<T> select(const Condition& c, const HenckyStrain<T>& a, const HenckyStrain<T>& b) {
  return {select(c, a.mean, b.mean), select(c, a.squared_size, b.squared_size), select(c, a.deviator, b.deviator)};
}

// For stretches that differ too much for ½ log b: ε = log V with the left stretch V = F Rᵀ. Returns where that does,
// never where `done`; the other strains stay as they are.
template <class T, class Condition>
PHYSMAS_CALL Condition strain_of_left_stretch(const Mat3<T>& F, const T& J, const Condition& done,
                                              HenckyStrain<T>& strain) {
  const Mat3<T> V = times_transposed(F, polar_rotation(F));
  const Deviation<T> S = deviation(from_matrix(T(Scalar<T>(0.5)) * (V + transpose(V))));
  constexpr double kLow = 1.1 * kStretchFloor / (1 - kDeviationRange<T>);
  constexpr double kHigh = 0.5 * kDeformationCap;
  const auto good = !done && J > T(0) && S.mean > T(static_cast<Scalar<T>>(kLow)) &&
                    S.mean < T(static_cast<Scalar<T>>(kHigh)) && in_range(S);
  strain = select(good, logarithm(S, Scalar<T>(1)), strain);
  return good;
}

// F after the plastic update of strains, where `moved`.
template <class T, class Condition>
PHYSMAS_INLINE Mat3<T> plastic_update(const Mat3<T>& F, const HenckyStrain<T>& strain, const Radial<T>& map,
                                      const Condition& moved) {
  using S = Scalar<T>;
  // exp(shift I + power D) F, where the deviator's part is small enough for its series or, rarely, four times a
  // quarter.
  T power = map.keep - T(1);
  const auto large = strain.squared_size * (power * power) > T(S(0.0625));
  const bool parts = any(large && moved);
  if (parts) power = select(large, S(0.25) * power, power);
  const T squared = power * power;
  const Quadratic<T> c =
      exponential_less_one(squared * (S(0.5) * strain.squared_size), squared * power * determinant(strain.deviator));
  const Mat3<T> G =
      to_matrix(evaluate<T>({c.c0, c.c1 * power, c.c2 * squared}, strain.deviator, square(strain.deviator)));
  Mat3<T> moved_F = F + G * F;
  for (int k = 1; parts && k < 4; ++k) moved_F = select(large, moved_F + G * moved_F, moved_F);
  const T shift = map.mean - strain.mean;
  const auto swells = absolute(shift) > T(0);
  if (any(swells && moved)) moved_F = select(swells, exponential(shift) * moved_F, moved_F);
  return select(moved, moved_F, F);
}

template <class T>
PHYSMAS_INLINE Mat3<T> update_hencky(Branch branch, const MaterialParameters<T>& p, const T& dt, Mat3<T>& F,
                                     T& strength) {
  using S = Scalar<T>;
  const Deviation<T> b = deviation(left_cauchy_green(F));
  const T J = determinant(F);
  HenckyStrain<T> strain = logarithm(b, S(0.5));
  auto ordinary = ordinary_stretch(b, J);
  Mat3<T> other_tau, other_F;
  T other_strength;
  bool exceptional = false;
  if (__builtin_expect(!all(ordinary), false)) {
    // Calls get copies, so that the originals need not be in memory.
    const Mat3<T> trial = F;
    HenckyStrain<T> wide = strain;
    ordinary = ordinary || strain_of_left_stretch(trial, J, ordinary, wide);
    strain = wide;
    exceptional = !all(ordinary);
    if (exceptional) {
      other_F = F;
      other_strength = strength;
      other_tau = update_hencky_by_svd(branch, p, dt, other_F, other_strength);
    }
  }

  decltype(p.mu > p.mu) moved = T(1) < T(0);
  const Radial<T> map = return_map(branch, p, strain.mean, strain.squared_size, S(3) * b.mean, dt, strength, moved);
  moved = moved && ordinary;
  if (any(moved)) F = plastic_update(F, strain, map, moved);
  T tau_mean = (p.mu + p.mu + S(3) * p.lambda) * map.mean;
  T tau_keep = (p.mu + p.mu) * map.keep;
  if (has_stress_cone(branch)) {
    const Radial<T> cone = project_to_cone(tau_mean, (p.mu + p.mu) * map.size, p);
    tau_mean = cone.mean;
    tau_keep = tau_keep * cone.keep;
  }
  Mat3<T> tau = tau_keep * to_matrix(strain.deviator);
  for (int i = 0; i < 3; ++i) tau[i][i] += tau_mean;
  if (exceptional) {
    tau = select(ordinary, tau, other_tau);
    F = select(ordinary, F, other_F);
    strength = select(ordinary, strength, other_strength);
  }
  return tau;
}

}  // namespace physmas::mpm

#endif
