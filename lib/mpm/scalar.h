// The few operations that the solver's formulas need, for plain numbers, under names that SIMD lanes share (lanes.h).
#ifndef PHYSMAS_MPM_SCALAR_H
#define PHYSMAS_MPM_SCALAR_H

#include <cmath>
#include <limits>

// Small functions of lanes must not become calls: their arguments would travel through memory. A GPU compiler will want
// its own words here; sanitizers take minutes to instrument what is inlined into one function.
#if defined(__SANITIZE_ADDRESS__)
#define PHYSMAS_INLINE inline
#define PHYSMAS_LAMBDA_INLINE
#else
#define PHYSMAS_INLINE inline __attribute__((always_inline))
#define PHYSMAS_LAMBDA_INLINE __attribute__((always_inline))
#endif

namespace physmas::mpm {

// The type of one number inside T: T itself for float and double.
template <class T>
struct ScalarOf {
  using Type = T;
};
template <class T>
using Scalar = typename ScalarOf<T>::Type;

template <class T>
constexpr Scalar<T> kEpsilon = std::numeric_limits<Scalar<T>>::epsilon();
// Far above the smallest normal number, so that its square root and its reciprocal stay ordinary numbers.
template <class T>
constexpr Scalar<T> kTiny = std::numeric_limits<Scalar<T>>::min() * Scalar<T>(1e4);

// Σ c_k x^k.
template <class T, int N>
PHYSMAS_INLINE T polynomial(const T& x, const double (&c)[N]) {
  T sum(static_cast<Scalar<T>>(c[N - 1]));
  for (int k = N - 2; k >= 0; --k) sum = sum * x + T(static_cast<Scalar<T>>(c[k]));
  return sum;
}

PHYSMAS_INLINE float select(bool condition, float yes, float no) {
  return condition ? yes : no;
}
PHYSMAS_INLINE double select(bool condition, double yes, double no) {
  return condition ? yes : no;
}
// NaN in the first argument gives the second: a bad number never survives a clamp.
PHYSMAS_INLINE float at_least(float x, float low) {
  return x > low ? x : low;
}
PHYSMAS_INLINE double at_least(double x, double low) {
  return x > low ? x : low;
}
PHYSMAS_INLINE float at_most(float x, float high) {
  return x < high ? x : high;
}
PHYSMAS_INLINE double at_most(double x, double high) {
  return x < high ? x : high;
}

PHYSMAS_INLINE bool all(bool condition) {
  return condition;
}
PHYSMAS_INLINE bool any(bool condition) {
  return condition;
}

PHYSMAS_INLINE float square_root(float x) {
  return std::sqrt(x);
}
PHYSMAS_INLINE double square_root(double x) {
  return std::sqrt(x);
}
PHYSMAS_INLINE float absolute(float x) {
  return std::fabs(x);
}
PHYSMAS_INLINE double absolute(double x) {
  return std::fabs(x);
}
PHYSMAS_INLINE float natural_log(float x) {
  return std::log(x);
}
PHYSMAS_INLINE double natural_log(double x) {
  return std::log(x);
}
PHYSMAS_INLINE float exponential(float x) {
  return std::exp(x);
}
PHYSMAS_INLINE double exponential(double x) {
  return std::exp(x);
}
// x^(−1/3) of positive x.
PHYSMAS_INLINE float inverse_cube_root(float x) {
  return 1 / std::cbrt(x);
}
PHYSMAS_INLINE double inverse_cube_root(double x) {
  return 1 / std::cbrt(x);
}
PHYSMAS_INLINE float round_down(float x) {
  return std::floor(x);
}
PHYSMAS_INLINE double round_down(double x) {
  return std::floor(x);
}

}  // namespace physmas::mpm

#endif
