// Hencky elasticity, Ψ = μ |ε|² + λ/2 (tr ε)² with ε the logarithms of the principal stretches, and one step of the
// four branches that stand on it.
//
// Strains are evaluated at s_i = max(s_i, kStretchFloor), where s.z < 0 marks inversion; below the floor the principal
// first Piola stress is held constant (Irving et al. 2004): τ_i is scaled by s_i / kStretchFloor, so an inverted
// element is pulled back through zero. A plastic update writes the floored stretch into F.
#ifndef PHYSMAS_MPM_HENCKY_H
#define PHYSMAS_MPM_HENCKY_H

#include "mpm/hyperelastic.h"
#include "mpm/plasticity.h"

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
// plasticine, and returns the Kirchhoff stress. The reference for the closed form below.
template <class T>
inline Mat3<T> update_hencky_by_svd(Branch branch, const MaterialParameters<T>& p, const T& dt, Mat3<T>& F,
                                    T& strength) {
  const Stretches<T> q = stretches(F);
  decltype(p.mu > p.mu) moved = T(1) < T(0);
  T trace_b(0);
  for (int i = 0; i < 3; ++i) trace_b += exponential(q.strain[i] + q.strain[i]);
  const Radial<T> map = return_map(branch, p, Scalar<T>(1.0 / 3.0) * sum(q.strain), norm(deviator(q.strain)), trace_b,
                                   dt, strength, moved);
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

// ---- In closed form: every τ_i is a mean plus a multiple of the deviatoric strain, and the plastic update is
// F ← exp(ε' − ε) F, so both are isotropic functions of b = F Fᵀ.

// exp(ε' − ε) − 1 with ε' = map(ε): eigenvalues exp(x_i) − 1, x_i = shift + (keep − 1) dev ε_i. difference: divided
// differences of the strain, number 1 to 2 and 2 to 3; inverse: of the gap 1 to 3.
template <class T>
PHYSMAS_INLINE Symmetric<T> plastic_increment(const Spectrum<T>& q, const Vec3<T>& deviatoric, const T& mean,
                                              const Radial<T>& map, const T& difference12, const T& difference23,
                                              const T& inverse) {
  using S = Scalar<T>;
  const T power = map.keep - T(1), shift = map.mean - mean, half = S(0.5) * power;
  // exp x_i − exp x_j = 2 exp((x_i + x_j) / 2) sinh((x_i − x_j) / 2), and the x_i add up to 3 shift.
  const T x1 = shift + power * deviatoric.x, x12 = shift - half * deviatoric.z, x23 = shift - half * deviatoric.x;
  const T y12 = half * (deviatoric.x - deviatoric.y), y23 = half * (deviatoric.y - deviatoric.z);
  T less_one, g12, g23;
  const T most = at_least(at_least(absolute(x1), absolute(x12)), absolute(x23));
  if (all(most < T(S(0.25)))) {  // so |y| < 1/2: a step's plastic strain is small
    less_one = x1 * exponential_less_one_over(x1);
    g12 = (T(1) + x12 * exponential_less_one_over(x12)) * sinh_series(y12);
    g23 = (T(1) + x23 * exponential_less_one_over(x23)) * sinh_series(y23);
  } else {
    less_one = exponential(x1) - T(1);
    g12 = exponential(x12) * sinh_over(y12);
    g23 = exponential(x23) * sinh_over(y23);
  }
  g12 = g12 * (power * difference12);
  g23 = g23 * (power * difference23);
  return isotropic(q, less_one, g12, (g12 - g23) * inverse);
}

template <class T>
PHYSMAS_INLINE Mat3<T> update_hencky(Branch branch, const MaterialParameters<T>& p, const T& dt, Mat3<T>& F,
                                     T& strength) {
  using S = Scalar<T>;
  const Spectrum<T> q = spectrum_of_left_cauchy_green(F);
  const auto ordinary = ordinary_stretch(q, determinant(F));
  Mat3<T> other_tau{}, other_F = F;
  T other_strength = strength;
  const bool exceptional = !all(ordinary);
  if (exceptional) other_tau = update_hencky_by_svd(branch, p, dt, other_F, other_strength);

  Vec3<T> strain;
  for (int i = 0; i < 3; ++i) strain[i] = S(0.5) * natural_log(q.value[i]);
  const T mean = S(1.0 / 3.0) * sum(strain);
  const Vec3<T> d = {strain.x - mean, strain.y - mean, strain.z - mean};
  const T size = norm(d);
  const T gap12 = q.offset.x - q.offset.y, gap23 = q.offset.y - q.offset.z;
  const T e12 = S(0.5) * log_difference(q.value.x, q.value.y, gap12, strain.x + strain.x, strain.y + strain.y);
  const T e23 = S(0.5) * log_difference(q.value.y, q.value.z, gap23, strain.y + strain.y, strain.z + strain.z);
  const T inverse = inverse_gap(q);
  decltype(p.mu > p.mu) moved = T(1) < T(0);
  const Radial<T> map = return_map(branch, p, mean, size, S(3) * q.mean, dt, strength, moved);
  moved = moved && ordinary;
  if (any(moved)) {
    F = select(moved, F + to_matrix(plastic_increment(q, d, mean, map, e12, e23, inverse)) * F, F);
  }
  T tau_mean = (p.mu + p.mu + S(3) * p.lambda) * map.mean;
  T tau_keep = (p.mu + p.mu) * map.keep;
  if (has_stress_cone(branch)) {
    const Radial<T> cone = project_to_cone(tau_mean, (p.mu + p.mu) * map.size, p);
    tau_mean = cone.mean;
    tau_keep = tau_keep * cone.keep;
  }
  Mat3<T> tau = to_matrix(isotropic(q, tau_mean + tau_keep * d.x, tau_keep * e12, tau_keep * ((e12 - e23) * inverse)));
  if (exceptional) {
    tau = select(ordinary, tau, other_tau);
    F = select(ordinary, F, other_F);
    strength = select(ordinary, strength, other_strength);
  }
  return tau;
}

}  // namespace physmas::mpm

#endif
