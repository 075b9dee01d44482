// Isotropic functions of a symmetric tensor S without its eigenvalues: f(S) as a polynomial of S, which by Cayley and
// Hamilton is a quadratic whose three coefficients take two multiplications per degree. Nearly equal eigenvalues are
// nothing special, and nothing is divided by their distance.
#ifndef PHYSMAS_MPM_MATH_ISOTROPIC_H
#define PHYSMAS_MPM_MATH_ISOTROPIC_H

#include "mpm/math/mat3.h"

namespace physmas::mpm {

template <class T>
struct Symmetric {
  T xx, yy, zz, xy, xz, yz;
};

template <class T>
PHYSMAS_INLINE Mat3<T> to_matrix(const Symmetric<T>& a) {
  return {{{a.xx, a.xy, a.xz}, {a.xy, a.yy, a.yz}, {a.xz, a.yz, a.zz}}};
}
template <class T>
PHYSMAS_INLINE Symmetric<T> from_matrix(const Mat3<T>& a) {
  return {a[0].x, a[1].y, a[2].z, a[0].y, a[0].z, a[1].z};
}
template <class T>
PHYSMAS_INLINE Symmetric<T> operator*(const T& s, const Symmetric<T>& a) {
  return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz};
}
template <class T>
PHYSMAS_INLINE Symmetric<T> operator+(const Symmetric<T>& a, const Symmetric<T>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}
template <class Condition, class T>
PHYSMAS_INLINE Symmetric<T> select(const Condition& c, const Symmetric<T>& a, const Symmetric<T>& b) {
  return {select(c, a.xx, b.xx), select(c, a.yy, b.yy), select(c, a.zz, b.zz),
          select(c, a.xy, b.xy), select(c, a.xz, b.xz), select(c, a.yz, b.yz)};
}
template <class T>
PHYSMAS_INLINE T trace(const Symmetric<T>& a) {
  return a.xx + a.yy + a.zz;
}
// |a|² of a matrix, its off-diagonal entries counted twice.
template <class T>
PHYSMAS_INLINE T squared_norm(const Symmetric<T>& a) {
  const T outer = a.xy * a.xy + a.xz * a.xz + a.yz * a.yz;
  return (a.xx * a.xx + a.yy * a.yy + a.zz * a.zz) + (outer + outer);
}
template <class T>
PHYSMAS_INLINE T determinant(const Symmetric<T>& a) {
  return a.xx * (a.yy * a.zz - a.yz * a.yz) + a.xy * (a.yz * a.xz - a.xy * a.zz) + a.xz * (a.xy * a.yz - a.yy * a.xz);
}
template <class T>
PHYSMAS_INLINE Symmetric<T> square(const Symmetric<T>& a) {
  const T xy2 = a.xy * a.xy, xz2 = a.xz * a.xz, yz2 = a.yz * a.yz;
  return {a.xx * a.xx + (xy2 + xz2),          a.yy * a.yy + (xy2 + yz2),          a.zz * a.zz + (xz2 + yz2),
          a.xy * (a.xx + a.yy) + a.xz * a.yz, a.xz * (a.xx + a.zz) + a.xy * a.yz, a.yz * (a.yy + a.zz) + a.xy * a.xz};
}
// F Fᵀ.
template <class T>
PHYSMAS_INLINE Symmetric<T> left_cauchy_green(const Mat3<T>& F) {
  return {dot(F[0], F[0]), dot(F[1], F[1]), dot(F[2], F[2]), dot(F[0], F[1]), dot(F[0], F[2]), dot(F[1], F[2])};
}

// c0 I + c1 A + c2 A².
template <class T>
struct Quadratic {
  T c0, c1, c2;
};
template <class T>
PHYSMAS_INLINE Symmetric<T> evaluate(const Quadratic<T>& c, const Symmetric<T>& A, const Symmetric<T>& A2) {
  return {c.c0 + c.c1 * A.xx + c.c2 * A2.xx, c.c0 + c.c1 * A.yy + c.c2 * A2.yy, c.c0 + c.c1 * A.zz + c.c2 * A2.zz,
          c.c1 * A.xy + c.c2 * A2.xy,        c.c1 * A.xz + c.c2 * A2.xz,        c.c1 * A.yz + c.c2 * A2.yz};
}

// Σ c_k A^(k+1) for A without a trace: A³ = q A + r I, q = |A|² / 2, r = det A. Horner's scheme.
template <class T, int N>
PHYSMAS_INLINE Quadratic<T> polynomial_of_tensor(const T& q, const T& r, const double (&c)[N]) {
  using S = Scalar<T>;
  Quadratic<T> sum = {T(static_cast<S>(c[N - 3])), T(static_cast<S>(c[N - 2])), T(static_cast<S>(c[N - 1]))};
  for (int k = N - 4; k >= 0; --k) sum = {r * sum.c2 + T(static_cast<S>(c[k])), q * sum.c2 + sum.c0, sum.c1};
  return {r * sum.c2, q * sum.c2 + sum.c0, sum.c1};
}

// S = m (I + A), m = tr S / 3.
template <class T>
struct Deviation {
  T mean;              // m
  Symmetric<T> A, A2;  // A and its square
  T q, r;              // |A|² / 2, det A
};

template <class T>
PHYSMAS_INLINE Deviation<T> deviation(const Symmetric<T>& S) {
  Deviation<T> d;
  d.mean = Scalar<T>(1.0 / 3.0) * trace(S);
  const T inverse = T(1) / at_least(d.mean, T(kTiny<T>));
  d.A = inverse * Symmetric<T>{S.xx - d.mean, S.yy - d.mean, S.zz - d.mean, S.xy, S.xz, S.yz};
  d.A2 = square(d.A);
  d.q = Scalar<T>(0.5) * squared_norm(d.A);
  d.r = determinant(d.A);
  return d;
}

// The polynomials below hold where no eigenvalue of S is further from the mean than this part of it; eigenvalues of A
// are at most 2 √(q/3). For b = F Fᵀ that means principal stretches within a factor of 1.6 to 2.1 (float), 1.4 to 1.6
// (double).
template <class T>
constexpr double kDeviationRange = sizeof(Scalar<T>) == 4 ? 0.7 : 0.5;
template <class T>
PHYSMAS_INLINE auto in_range(const Deviation<T>& d) {
  return d.q < T(static_cast<Scalar<T>>(0.75 * kDeviationRange<T> * kDeviationRange<T>));
}

// log(I + A): Σ c_k x^k interpolates log(1 + x) / x at Chebyshev nodes, within 4e-8 for float, 1e-16 for double.
template <class T>
PHYSMAS_INLINE Quadratic<T> log_of_one_plus(const Deviation<T>& d) {
  if constexpr (sizeof(Scalar<T>) == 4) {
    return polynomial_of_tensor(
        d.q, d.r,
        {1.0, -0.499999505, 0.333332859, -0.250048001, 0.200046023, -0.165326392, 0.141572197, -0.141525995, 0.12695272,
         0.00560408185, -0.0102999857, -0.452392461, 0.430504416, 0.613880075, -0.589532697, -0.627953948, 0.59962789});
  } else {
    return polynomial_of_tensor(d.q, d.r,
                                {1.0,
                                 -0.50000000000000122,
                                 0.33333333333333452,
                                 -0.24999999999940766,
                                 0.19999999999942583,
                                 -0.16666666675157244,
                                 0.1428571429394435,
                                 -0.12499999434977042,
                                 0.11111110563432153,
                                 -0.10000021115598326,
                                 0.090909295579308594,
                                 -0.083328431092942759,
                                 0.076918325387649363,
                                 -0.071503481928953144,
                                 0.066739271602785922,
                                 -0.061722220599458174,
                                 0.058069725113328319,
                                 -0.061111070374531374,
                                 0.058015487022870712,
                                 -0.022869596277156674,
                                 0.021329130323545463,
                                 -0.13334403053387122,
                                 0.12863325679149495,
                                 0.13389890526046439,
                                 -0.1300648115161751,
                                 -0.21776403107855093,
                                 0.21064057596406979});
  }
}

// √(I + A) − I, likewise.
template <class T>
PHYSMAS_INLINE Quadratic<T> root_of_one_plus(const Deviation<T>& d) {
  if constexpr (sizeof(Scalar<T>) == 4) {
    return polynomial_of_tensor(
        d.q, d.r,
        {0.5, -0.125000187, 0.062500174, -0.0390483951, 0.027330644, -0.0208100513, 0.0163940595, -0.0102978527,
         0.0083151602, -0.0221001115, 0.0199136603, 0.0226310673, -0.021281608, -0.035371226, 0.0325857847});
  } else {
    return polynomial_of_tensor(d.q, d.r,
                                {0.5,
                                 -0.1249999999999991,
                                 0.062499999999999148,
                                 -0.039062500000372215,
                                 0.027343750000353705,
                                 -0.02050781245437985,
                                 0.016113281206649239,
                                 -0.01309204360046538,
                                 0.010910036635875013,
                                 -0.0092734473553080464,
                                 0.0080088792811818581,
                                 -0.007009425779923206,
                                 0.0062007499592288938,
                                 -0.0055149898425757348,
                                 0.0049624873053694765,
                                 -0.0046829833907025639,
                                 0.0042762136648483094,
                                 -0.0028278370529887283,
                                 0.0025773961377023822,
                                 -0.0066737664376262259,
                                 0.0062698133035188585,
                                 0.0049390089586709576,
                                 -0.0047285609973217743,
                                 -0.011243385825998336,
                                 0.010643697423303567});
  }
}

// exp(D) − I for D without a trace and with eigenvalues of at most 1/4; q and r of D. Taylor's series.
template <class T>
PHYSMAS_INLINE Quadratic<T> exponential_less_one(const T& q, const T& r) {
  if constexpr (sizeof(Scalar<T>) == 4) {
    return polynomial_of_tensor(q, r, {1.0, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720});
  } else {
    return polynomial_of_tensor(q, r,
                                {1.0, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040, 1.0 / 40320,
                                 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600});
  }
}

}  // namespace physmas::mpm

#endif
