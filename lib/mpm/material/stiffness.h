// How stiff a deformed particle is: the largest factor between a velocity gradient and the rate of stress that it
// causes. The explicit step is bounded by it (timestep.h; derivation in docs/numerics.md).
#ifndef PHYSMAS_MPM_MATERIAL_STIFFNESS_H
#define PHYSMAS_MPM_MATERIAL_STIFFNESS_H

#include "mpm/material/constitutive.h"

namespace physmas::mpm {

// Principal stretches of F in descending order, the last with the sign of J = det F: roots of the eigenvalues of F Fᵀ,
// m (1 + 2 p cos φ) with cos 3φ = r. They lose digits where they differ by orders of magnitude, which a bound can bear;
// their product is J all the same unless two of them are lost.
template <class T>
PHYSMAS_INLINE Vec3<T> principal_stretches(const Mat3<T>& F) {
  using S = Scalar<T>;
  const Deviation<T> b = deviation(left_cauchy_green(F));
  const T p = square_root(S(1.0 / 3.0) * b.q);
  const T inverse = T(1) / at_least(p, T(S(1e-9)));
  const T ratio = (S(0.5) * b.r * inverse) * (inverse * inverse);
  const T r = at_most(absolute(ratio), T(1));
  // 4 t³ − 3 t = |r| for t = cos φ in [√3/2, 1]: interpolated at Chebyshev nodes, then a step of Newton's.
  T t = polynomial(r, {0.866025416, 0.166665043, -0.0480773503, 0.0243923838, -0.0142895648, 0.00766430176,
                       -0.0029228305, 0.000542607713});
  t = (S(8) * t * (t * t) + r) / (S(12) * (t * t) - T(3));
  const T s = S(1.7320508075688772) * square_root(at_least(T(1) - t * t, T(0)));
  // r < 0 is the mirror image: the two that are close are the larger ones.
  const auto mirrored = ratio < T(0);
  const T first = square_root(b.mean * (T(1) + p * select(mirrored, s + t, t + t)));
  const T second = square_root(b.mean * at_least(T(1) + p * select(mirrored, t - s, s - t), T(0)));
  const T third = determinant(F) / at_least(first * second, T(kTiny<T>));
  return {first, second, at_least(at_most(third, second), -second)};
}

// The tangent of the principal Kirchhoff stresses. `normal[i][j]` = s_j ∂τ_i/∂s_j [Pa].
template <class T>
struct PrincipalTangent {
  Vec3<T> tau;     // [Pa]
  Mat3<T> normal;  // [Pa]
};

template <class T>
PHYSMAS_INLINE PrincipalTangent<T> jelly_tangent(const Vec3<T>& s, const T& mu, const T& bulk) {
  const Vec3<T> b = {s.x * s.x, s.y * s.y, s.z * s.z};
  const T J = s.x * s.y * s.z, trace_b = b.x + b.y + b.z;
  const JellyTerms<T> j = jelly_terms(J);
  // Second derivatives, times J²; zero where g and U are continued by their tangents.
  const auto below = J < T(static_cast<Scalar<T>>(kStretchFloor));
  const T ddg = select(below, T(0), Scalar<T>(10.0 / 9.0) * j.g);
  const T ddU = select(below, T(0), Scalar<T>(0.5) * (J * J + T(1)));
  const T dg = j.dg * J, dU = j.dU * J;
  const T common = Scalar<T>(0.5) * mu * trace_b * (ddg + dg) + bulk * (ddU + dU);
  PrincipalTangent<T> t;
  for (int i = 0; i < 3; ++i) {
    t.tau[i] = mu * (j.g * b[i] + Scalar<T>(0.5) * dg * trace_b) + bulk * dU;
    for (int k = 0; k < 3; ++k) t.normal[i][k] = common + mu * dg * (b[i] + b[k]);
    t.normal[i][i] += (mu + mu) * j.g * b[i];
  }
  return t;
}

template <class T>
PHYSMAS_INLINE PrincipalTangent<T> metal_tangent(const Vec3<T>& s, const T& mu, const T& lambda) {
  const T J = s.x * s.y * s.z;
  PrincipalTangent<T> t;
  for (int i = 0; i < 3; ++i) {
    t.tau[i] = (mu + mu) * (s[i] - T(1)) * s[i] + lambda * (J - T(1)) * J;
    for (int k = 0; k < 3; ++k) t.normal[i][k] = lambda * (J + J - T(1)) * J;
    t.normal[i][i] += (mu + mu) * (s[i] + s[i] - T(1)) * s[i];
  }
  return t;
}

template <class T>
PHYSMAS_INLINE PrincipalTangent<T> hencky_tangent(const Vec3<T>& s, const T& mu, const T& lambda) {
  const T floor(static_cast<Scalar<T>>(kStretchFloor));
  Vec3<T> strain, inside;
  for (int i = 0; i < 3; ++i) {
    const T floored = at_least(s[i], floor);
    strain[i] = natural_log(floored);
    inside[i] = s[i] / floored;
  }
  PrincipalTangent<T> t;
  t.tau = hencky_principal(strain, mu, lambda);
  for (int i = 0; i < 3; ++i) {
    t.tau[i] = t.tau[i] * inside[i];
    // A stretch below the floor has no strain of its own any more: τ_k is proportional to s_k.
    for (int k = 0; k < 3; ++k) t.normal[i][k] = select(s[k] < floor, T(0), lambda * inside[i]);
    t.normal[i][i] += select(s[i] < floor, t.tau[i], mu + mu);
  }
  return t;
}

// Stiffness of a particle at rest [Pa]: three times the bulk modulus against a change of volume, 2 μ against the rest.
template <class T>
PHYSMAS_INLINE T rest_stiffness(const MaterialParameters<T>& p) {
  return at_least(Scalar<T>(3) * p.bulk, p.mu + p.mu);
}

// Upper bound a [Pa] of the stiffness of a particle with the elastic deformation F: |rate of τ| <= a |velocity
// gradient|, the stress's own share from the motion of the particle included, and never below the stiffness at rest.
// Isotropy makes the tangent fall apart into the 3×3 block of the principal stresses (bounded by its largest row sum)
// and a 2×2 block for each pair of directions. Return maps and the stress cut only take stiffness away, up to the
// coupling of pressure into the deviator that Drucker–Prager adds.
template <class T>
PHYSMAS_HOST_DEVICE inline T stiffness_bound(Branch branch, const MaterialParameters<T>& p, const Mat3<T>& F) {
  const Vec3<T> s = principal_stretches(cap_deformation(F));
  PrincipalTangent<T> t = branch == Branch::jelly   ? jelly_tangent(s, p.mu, p.bulk)
                          : branch == Branch::metal ? metal_tangent(s, p.mu, p.lambda)
                                                    : hencky_tangent(s, p.mu, p.lambda);
  const bool cut = has_stress_cone(branch);
  if (cut) t.tau = project_to_cone(t.tau, p);
  T normal(0), shear(0), stress(0);
  for (int i = 0; i < 3; ++i) {
    normal = at_least(absolute(t.normal[i].x) + absolute(t.normal[i].y) + absolute(t.normal[i].z), normal);
    stress = at_least(absolute(t.tau[i]), stress);
    // Shear of directions i and k: (τ_i − τ_k) / (b_i − b_k), b = s², between stress and the rate of F Fᵀ.
    const int k = (i + 1) % 3;
    const T bi = s[i] * s[i], bk = s[k] * s[k];
    const T both = at_least(bi + bk, T(kTiny<T>));
    const T unequal = absolute(bi - bk) / both;
    T half;
    if (branch == Branch::jelly) {
      half = Scalar<T>(0.5) * p.mu * jelly_terms(s.x * s.y * s.z).g * both;
    } else if (branch == Branch::metal) {
      // 2 μ (1 − 1/(s_i + s_k)). An inversion has s_i + s_k near 0, where R jumps: a jump, not a stiffness.
      const T sum_s = at_least(absolute(s[i] + s[k]), Scalar<T>(0.1) * square_root(both));
      half = p.mu * both * (T(1) + T(1) / sum_s);
      half = select(s[k] > T(0) && s[i] > T(0), p.mu * both * absolute(T(1) - T(1) / sum_s), half);
    } else {
      half = Scalar<T>(0.5) * absolute(t.tau[i] - t.tau[k]) / at_least(unequal, T(Scalar<T>(0.1)));
      half = at_least(half, Scalar<T>(1.01) * p.mu);
    }
    shear = at_least(half * (T(1) + square_root(T(1) + unequal * unequal)), shear);
  }
  T a = at_least(normal, shear);
  if (cut) {
    const T slope = branch == Branch::sand ? at_least(p.friction, p.alpha) : p.alpha;
    a = a * square_root(T(1) + Scalar<T>(3) * slope * slope);
  }
  return at_least(a + (stress + stress), rest_stiffness(p));
}

}  // namespace physmas::mpm

#endif
