// 3-vectors and 3×3 matrices of numbers or SIMD lanes: plain aggregates, passed by reference, usable on a GPU.
#ifndef PHYSMAS_MPM_MATH_MAT3_H
#define PHYSMAS_MPM_MATH_MAT3_H

#include "mpm/math/real.h"

namespace physmas::mpm {

template <class T>
struct Vec3 {
  T x, y, z;
  PHYSMAS_HOST_DEVICE T& operator[](int i) { return (&x)[i]; }
  PHYSMAS_HOST_DEVICE const T& operator[](int i) const { return (&x)[i]; }
};

template <class T>
PHYSMAS_INLINE Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
PHYSMAS_INLINE Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
PHYSMAS_INLINE Vec3<T> operator-(const Vec3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
PHYSMAS_INLINE Vec3<T> operator*(const T& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
PHYSMAS_INLINE T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
PHYSMAS_INLINE Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
PHYSMAS_INLINE T norm(const Vec3<T>& a) {
  return square_root(dot(a, a));
}

// Row-major: row[i][j] is the entry in row i, column j.
template <class T>
struct Mat3 {
  Vec3<T> row[3];
  PHYSMAS_HOST_DEVICE Vec3<T>& operator[](int i) { return row[i]; }
  PHYSMAS_HOST_DEVICE const Vec3<T>& operator[](int i) const { return row[i]; }
};

template <class T>
PHYSMAS_INLINE Mat3<T> diagonal(const T& a, const T& b, const T& c) {
  const T zero(0);
  return {{{a, zero, zero}, {zero, b, zero}, {zero, zero, c}}};
}
template <class T>
PHYSMAS_INLINE Mat3<T> identity() {
  return diagonal(T(1), T(1), T(1));
}
template <class T>
PHYSMAS_INLINE Mat3<T> operator+(const Mat3<T>& a, const Mat3<T>& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
template <class T>
PHYSMAS_INLINE Mat3<T> operator-(const Mat3<T>& a, const Mat3<T>& b) {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
template <class T>
PHYSMAS_INLINE Mat3<T> operator*(const T& s, const Mat3<T>& a) {
  return {{s * a[0], s * a[1], s * a[2]}};
}
template <class T>
PHYSMAS_INLINE Mat3<T> operator*(const Mat3<T>& a, const Mat3<T>& b) {
  Mat3<T> c;
  for (int i = 0; i < 3; ++i) c[i] = a[i].x * b[0] + a[i].y * b[1] + a[i].z * b[2];
  return c;
}
template <class T>
PHYSMAS_INLINE Vec3<T> operator*(const Mat3<T>& a, const Vec3<T>& v) {
  return {dot(a[0], v), dot(a[1], v), dot(a[2], v)};
}
template <class T>
PHYSMAS_INLINE Mat3<T> transpose(const Mat3<T>& a) {
  return {{{a[0].x, a[1].x, a[2].x}, {a[0].y, a[1].y, a[2].y}, {a[0].z, a[1].z, a[2].z}}};
}
// a bᵀ of two matrices: entry (i, j) is the dot product of row i of a and row j of b.
template <class T>
PHYSMAS_INLINE Mat3<T> times_transposed(const Mat3<T>& a, const Mat3<T>& b) {
  Mat3<T> c;
  for (int i = 0; i < 3; ++i) c[i] = {dot(a[i], b[0]), dot(a[i], b[1]), dot(a[i], b[2])};
  return c;
}
// Σ_i s_i u_i u_iᵀ with u_i the columns of U: an isotropic tensor from its principal values.
template <class T>
PHYSMAS_INLINE Mat3<T> from_principal(const Mat3<T>& U, const Vec3<T>& s) {
  Mat3<T> scaled;
  for (int i = 0; i < 3; ++i) scaled[i] = {U[i].x * s.x, U[i].y * s.y, U[i].z * s.z};
  return times_transposed(scaled, U);
}
template <class T>
PHYSMAS_INLINE T determinant(const Mat3<T>& a) {
  return dot(a[0], cross(a[1], a[2]));
}
template <class T>
PHYSMAS_INLINE T trace(const Mat3<T>& a) {
  return a[0].x + a[1].y + a[2].z;
}
// Sum of the squared entries.
template <class T>
PHYSMAS_INLINE T squared_norm(const Mat3<T>& a) {
  return dot(a[0], a[0]) + dot(a[1], a[1]) + dot(a[2], a[2]);
}
// Largest absolute entry.
template <class T>
PHYSMAS_INLINE T largest_entry(const Mat3<T>& a) {
  T m = absolute(a[0].x);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m = at_least(absolute(a[i][j]), m);
  return m;
}
template <class Condition, class T>
PHYSMAS_INLINE Vec3<T> select(const Condition& c, const Vec3<T>& a, const Vec3<T>& b) {
  return {select(c, a.x, b.x), select(c, a.y, b.y), select(c, a.z, b.z)};
}
template <class Condition, class T>
PHYSMAS_INLINE Mat3<T> select(const Condition& c, const Mat3<T>& a, const Mat3<T>& b) {
  return {{select(c, a[0], b[0]), select(c, a[1], b[1]), select(c, a[2], b[2])}};
}

using Vec3d = Vec3<double>;
using Mat3d = Mat3<double>;

}  // namespace physmas::mpm

#endif
