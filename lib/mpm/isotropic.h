// Isotropic functions of b = F Fᵀ in closed form: f(b) = Σ f(λ_i) n_i n_iᵀ without eigenvectors.
//
// Newton interpolation at the eigenvalues gives f(b) = f₁ I + f₁₂ (b − λ₁) + f₁₂₃ (b − λ₁)(b − λ₂) with divided
// differences f₁₂, f₁₂₃. An error δ of one eigenvalue enters multiplied by its distance from the others, so nearly
// equal eigenvalues, which any formula of the cubic finds with few digits, do no harm as long as the first divided
// differences are exact for the numbers they are given.
#ifndef PHYSMAS_MPM_ISOTROPIC_H
#define PHYSMAS_MPM_ISOTROPIC_H

#include "mpm/mat3.h"

namespace physmas::mpm {

template <class T>
struct Symmetric {
  T xx, yy, zz, xy, xz, yz;
};

template <class T>
PHYSMAS_INLINE Mat3<T> to_matrix(const Symmetric<T>& a) {
  return {{{a.xx, a.xy, a.xz}, {a.xy, a.yy, a.yz}, {a.xz, a.yz, a.zz}}};
}

// The spectrum of b = F Fᵀ. Number 1 is the eigenvalue that lies farthest from the other two, 3 is the farthest from 1.
template <class T>
struct Spectrum {
  T mean;                  // tr b / 3
  Vec3<T> offset;          // λ_i − mean
  Vec3<T> value;           // λ_i
  Symmetric<T> deviator;   // b − mean I
  Symmetric<T> quadratic;  // (b − λ₁)(b − λ₂)
};

// Roots of the characteristic cubic as 2 p cos φ with cos 3φ = r. For t = cos φ that is 4 t³ − 3 t = r; with r >= 0, t
// lies in [√3/2, 1], where Newton's iteration is well conditioned; r < 0 is the mirror image.
template <class T>
PHYSMAS_INLINE Spectrum<T> spectrum_of_left_cauchy_green(const Mat3<T>& F) {
  using S = Scalar<T>;
  const T xx = dot(F[0], F[0]), yy = dot(F[1], F[1]), zz = dot(F[2], F[2]);
  Spectrum<T> q;
  q.mean = S(1.0 / 3.0) * (xx + yy + zz);
  Symmetric<T>& A = q.deviator;
  A = {xx - q.mean, yy - q.mean, zz - q.mean, dot(F[0], F[1]), dot(F[0], F[2]), dot(F[1], F[2])};
  const T xy2 = A.xy * A.xy, xz2 = A.xz * A.xz, yz2 = A.yz * A.yz;
  const T outer = xy2 + xz2 + yz2;
  const T p2 = S(1.0 / 6.0) * (A.xx * A.xx + A.yy * A.yy + A.zz * A.zz + (outer + outer));
  const T p = square_root(p2);
  const T det = A.xx * (A.yy * A.zz - yz2) - A.yy * xz2 - A.zz * xy2 + S(2) * (A.xy * A.xz * A.yz);
  // r = det / 2 p³, without waiting for the root. Where b is a multiple of I to rounding, any r will do.
  const T inverse = T(1) / at_least(p2, S(1e-18) * (q.mean * q.mean) + T(kTiny<T>));
  const T ratio = (S(0.5) * det * inverse) * (inverse * p);
  const auto mirrored = ratio < T(0);
  const T r = at_most(absolute(ratio), T(1));
  // t and s = √3 sin φ, interpolated at Chebyshev nodes.
  T t, s;
  if constexpr (sizeof(S) == 4) {
    // Within 1.4e-8 both.
    t = polynomial(r, {0.866025416, 0.166665043, -0.0480773503, 0.0243923838, -0.0142895648, 0.00766430176,
                       -0.0029228305, 0.000542607713});
    s = square_root(T(1) - r) * polynomial(r, {0.866025395, -0.0669862248, 0.0266237455, -0.0147995785, 0.0090199563,
                                               -0.00493061026, 0.00189791456, -0.000354021966});
  } else {
    // Within 5e-6, and each of Newton's steps doubles the digits.
    t = polynomial(
        r, {0.866030432022691, 0.16641172178759583, -0.045921933130763676, 0.01751218857521032, -0.004035398716655251});
    for (int k = 0; k < 2; ++k) {
      const T t2 = t * t;
      t = (S(8) * t * t2 + r) / (S(12) * t2 - T(3));
    }
    s = S(1.7320508075688772) * square_root(at_least(T(1) - t * t, T(0)));
  }
  const T size = select(mirrored, -p, p);
  q.offset = {size * (t + t), size * (s - t), -(size * (s + t))};
  for (int i = 0; i < 3; ++i) q.value[i] = q.mean + q.offset[i];
  // A² + a₃ A + a₁ a₂, since the offsets a sum to zero.
  const T& a3 = q.offset.z;
  const T product = q.offset.x * q.offset.y;
  q.quadratic = {A.xx * (A.xx + a3) + (xy2 + xz2) + product, A.yy * (A.yy + a3) + (xy2 + yz2) + product,
                 A.zz * (A.zz + a3) + (xz2 + yz2) + product, A.xy * (A.xx + A.yy + a3) + A.xz * A.yz,
                 A.xz * (A.xx + A.zz + a3) + A.xy * A.yz,    A.yz * (A.yy + A.zz + a3) + A.xy * A.xz};
  return q;
}

template <class T>
PHYSMAS_INLINE T smallest(const Vec3<T>& a) {
  return at_most(at_most(a.x, a.y), a.z);
}
template <class T>
PHYSMAS_INLINE T largest(const Vec3<T>& a) {
  return at_least(at_least(a.x, a.y), a.z);
}

// f(b) from f₁ and the divided differences f₁₂ and f₁₂₃.
template <class T>
PHYSMAS_INLINE Symmetric<T> isotropic(const Spectrum<T>& q, const T& f1, const T& f12, const T& f123) {
  const Symmetric<T>&A = q.deviator, &D = q.quadratic;
  const T diagonal = f1 - f12 * q.offset.x;
  return {diagonal + f12 * A.xx + f123 * D.xx,
          diagonal + f12 * A.yy + f123 * D.yy,
          diagonal + f12 * A.zz + f123 * D.zz,
          f12 * A.xy + f123 * D.xy,
          f12 * A.xz + f123 * D.xz,
          f12 * A.yz + f123 * D.yz};
}

// 1 / (λ₁ − λ₃), which makes (f₁₂ − f₂₃) the second difference f₁₂₃. Zero where all eigenvalues are the same to
// rounding: the factor of f₁₂₃ is the square of their distance.
template <class T>
PHYSMAS_INLINE T inverse_gap(const Spectrum<T>& q) {
  const T gap = q.offset.x - q.offset.z;
  const auto apart = absolute(gap) > kEpsilon<T> * q.mean;
  return select(apart, T(1) / select(apart, gap, T(1)), T(0));
}

// (log a − log b) / (a − b) for positive a, b whose logarithms are given. For close numbers the series of
// 2 atanh(z) / (a − b), z = (a − b) / (a + b): the logarithms' difference has lost its digits there.
template <class T>
PHYSMAS_INLINE T log_difference(const T& a, const T& b, const T& gap, const T& log_a, const T& log_b) {
  using S = Scalar<T>;
  const T sum = a + b;
  const auto close = gap * gap < S(0.01) * (sum * sum);
  const T inverse = T(1) / select(close, sum, gap);
  const T z = gap * inverse, z2 = z * z;
  constexpr int kTerms = sizeof(S) == 4 ? 4 : 8;  // z² < 0.01: the first term left out is below rounding
  T series(S(2) / S(2 * kTerms + 1));
  for (int k = kTerms - 1; k >= 0; --k) series = series * z2 + T(S(2) / S(2 * k + 1));
  return select(close, series, log_a - log_b) * inverse;
}

// sinh(y) / y for |y| < 1/2, within 2 ulp.
template <class T>
PHYSMAS_INLINE T sinh_series(const T& y) {
  const T y2 = y * y;
  if constexpr (sizeof(Scalar<T>) == 4) {
    return polynomial(y2, {1.0, 1.0 / 6, 1.0 / 120, 1.0 / 5040});
  } else {
    return polynomial(y2, {1.0, 1.0 / 6, 1.0 / 120, 1.0 / 5040, 1.0 / 362880, 1.0 / 39916800, 1.0 / 6227020800,
                           1.0 / 1307674368000});
  }
}

// sinh(y) / y.
template <class T>
PHYSMAS_INLINE T sinh_over(const T& y) {
  using S = Scalar<T>;
  const auto close = absolute(y) < T(S(0.5));
  const T e = exponential(y);
  return select(close, sinh_series(y), S(0.5) * (e - T(1) / e) / select(close, T(1), y));
}

// V = √b, the symmetric left stretch of F. The divided differences of a square root are rational.
template <class T>
PHYSMAS_INLINE Symmetric<T> left_stretch(const Spectrum<T>& q) {
  Vec3<T> s;
  for (int i = 0; i < 3; ++i) s[i] = square_root(at_least(q.value[i], T(0)));
  // f₁₂ = 1 / (s₁ + s₂), f₁₂₃ = −1 / ((s₁ + s₂) (s₂ + s₃) (s₁ + s₃)).
  const T rest = (s.y + s.z) * (s.x + s.z);
  const T inverse = T(1) / at_least((s.x + s.y) * rest, T(kTiny<T>));
  return isotropic(q, s.x, rest * inverse, -inverse);
}

}  // namespace physmas::mpm

#endif
