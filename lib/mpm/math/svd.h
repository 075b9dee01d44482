// Singular value and polar decomposition of 3×3 matrices, for numbers and for SIMD lanes, valid for every finite input.
#ifndef PHYSMAS_MPM_MATH_SVD_H
#define PHYSMAS_MPM_MATH_SVD_H

#include "mpm/math/mat3.h"

namespace physmas::mpm {

// F = U diag(s) Vᵀ with U and V proper rotations (determinant +1), s.x >= s.y >= |s.z|, and s.z carrying the sign of
// det F. `Vt` holds Vᵀ: its rows are the right singular vectors.
template <class T>
struct Svd {
  Mat3<T> U;
  Vec3<T> s;
  Mat3<T> Vt;
};

namespace svd_detail {

// Whether rows p and q of B are orthogonal to rounding.
template <class T>
PHYSMAS_INLINE auto orthogonal_rows(const Mat3<T>& B, int p, int q) {
  const T c = dot(B[p], B[q]);
  const Scalar<T> tolerance = kEpsilon<T> * kEpsilon<T>;
  return c * c <= T(tolerance) * (dot(B[p], B[p]) * dot(B[q], B[q])) + T(kTiny<T>);
}

// One Jacobi rotation that makes rows p and q of B orthogonal, applied to the columns of U (rows of Ut) as well, so
// that U B stays the same (Hestenes 1958).
template <class T>
PHYSMAS_INLINE void rotate_rows(Mat3<T>& B, Mat3<T>& Ut, int p, int q) {
  const T a = dot(B[p], B[p]), b = dot(B[q], B[q]), c = dot(B[p], B[q]);
  const T d = b - a, c2 = c + c;
  const T root = square_root(d * d + c2 * c2);
  const T t = select(d < T(0), -c2, c2) / (absolute(d) + root + T(kTiny<T>));
  const T cosine = T(1) / square_root(T(1) + t * t), sine = cosine * t;
  const Vec3<T> bp = B[p], bq = B[q], up = Ut[p], uq = Ut[q];
  B[p] = cosine * bp - sine * bq;
  B[q] = sine * bp + cosine * bq;
  Ut[p] = cosine * up - sine * uq;
  Ut[q] = sine * up + cosine * uq;
}

// Exchanges rows p and q where |B_p| < |B_q|, turning one of them around so that both factors keep their handedness.
template <class T>
PHYSMAS_INLINE void order_rows(Mat3<T>& B, Mat3<T>& Ut, Vec3<T>& n, int p, int q) {
  const auto swap = n[p] < n[q];
  const Vec3<T> bp = B[p], up = Ut[p];
  const T np = n[p];
  B[p] = select(swap, B[q], bp);
  B[q] = select(swap, -bp, B[q]);
  Ut[p] = select(swap, Ut[q], up);
  Ut[q] = select(swap, -up, Ut[q]);
  n[p] = select(swap, n[q], np);
  n[q] = select(swap, np, n[q]);
}

}  // namespace svd_detail

// One-sided Jacobi on the rows of F, cyclic, until all pairs are orthogonal to rounding (quadratic convergence: three
// to five sweeps). Small singular values keep their relative accuracy, unlike with eigenvalues of F Fᵀ. F is scaled by
// its largest entry first, so tiny and huge matrices are fine; the zero matrix (and subnormal entries) gives s = 0 and
// identity rotations.
template <class T>
PHYSMAS_INLINE Svd<T> svd(const Mat3<T>& F) {
  using svd_detail::order_rows;
  using svd_detail::orthogonal_rows;
  using svd_detail::rotate_rows;
  const T largest = largest_entry(F);
  // Down to the smallest normal number, whose reciprocal is still finite.
  const T scale = select(largest >= T(kSmallest<T>), largest, T(1));
  Mat3<T> B = (T(1) / scale) * F;
  Mat3<T> Ut = identity<T>();
  constexpr int kMaxSweeps = 12;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    if (all(orthogonal_rows(B, 0, 1) && orthogonal_rows(B, 0, 2) && orthogonal_rows(B, 1, 2))) break;
    rotate_rows(B, Ut, 0, 1);
    rotate_rows(B, Ut, 0, 2);
    rotate_rows(B, Ut, 1, 2);
  }
  Vec3<T> n = {dot(B[0], B[0]), dot(B[1], B[1]), dot(B[2], B[2])};
  order_rows(B, Ut, n, 0, 1);
  order_rows(B, Ut, n, 0, 2);
  order_rows(B, Ut, n, 1, 2);

  Svd<T> result;
  result.U = transpose(Ut);
  // Right singular vectors: the first from B, the second made orthogonal to it (any direction will do when F has rank
  // one), the third from the cross product, which makes V a proper rotation and gives s.z its sign.
  const T s0 = square_root(n.x);
  const auto zero = n.x < T(kTiny<T>);
  const T one(1), none(0);
  const Vec3<T> v0 = select(zero, Vec3<T>{one, none, none}, (T(1) / at_least(s0, T(kTiny<T>))) * B[0]);
  const Vec3<T> second = B[1] - dot(B[1], v0) * v0;
  const T length = norm(second);
  const auto flat = n.y < T(kTiny<T>);
  // A direction away from v0: the axis on which v0 is shortest.
  const auto x_small = absolute(v0.x) < T(Scalar<T>(0.57));
  const Vec3<T> axis = select(x_small, Vec3<T>{one, none, none}, Vec3<T>{none, one, none});
  const Vec3<T> side = axis - dot(axis, v0) * v0;
  const Vec3<T> v1 = select(flat, (T(1) / norm(side)) * side, (T(1) / at_least(length, T(kTiny<T>))) * second);
  const Vec3<T> v2 = cross(v0, v1);
  result.Vt = {{v0, v1, v2}};
  result.s = {scale * s0, scale * select(flat, none, length), scale * dot(B[2], v2)};
  return result;
}

// The rotation R of F = R S with det R = +1 for every F: the closest proper rotation in the Frobenius norm. Newton's
// iteration X ← (X + X⁻ᵀ) / 2 (Higham 1986) where F is well away from collapse, as it nearly always is; the singular
// value decomposition for the rest, where Newton would be slow or end in a reflection.
template <class T>
PHYSMAS_INLINE Mat3<T> polar_rotation(const Mat3<T>& F) {
  const Scalar<T> half(0.5);
  Mat3<T> X = F;
  const T size = squared_norm(F), volume = determinant(F);
  // At least a thousandth of the volume of a cube with the same norm, neither tiny nor huge.
  const auto ordinary = volume > T(Scalar<T>(1e-3)) * size * square_root(size) * T(Scalar<T>(0.19)) &&
                        size > T(Scalar<T>(1e-4)) && size < T(Scalar<T>(1e4));
  if (!all(ordinary)) {
    const Svd<T> d = svd(F);
    const Mat3<T> R = d.U * d.Vt;
    if (!any(ordinary)) return R;
    X = select(ordinary, X, R);
  }
  constexpr int kMaxSteps = 20;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vec3<T> c0 = cross(X[1], X[2]), c1 = cross(X[2], X[0]), c2 = cross(X[0], X[1]);
    const T scale = T(half) / dot(X[0], c0);
    const Mat3<T> next = {{T(half) * X[0] + scale * c0, T(half) * X[1] + scale * c1, T(half) * X[2] + scale * c2}};
    const T change = squared_norm(next - X);
    X = next;
    // Quadratic: a change of δ leaves an error of δ²/2.
    if (all(change < T(kEpsilon<T>))) break;
  }
  return X;
}

}  // namespace physmas::mpm

#endif
