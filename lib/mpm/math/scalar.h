// The few operations that the solver's formulas need, for plain numbers, under names that SIMD lanes share (lanes.h).
#ifndef PHYSMAS_MPM_MATH_SCALAR_H
#define PHYSMAS_MPM_MATH_SCALAR_H

#include <cmath>
#include <limits>

// Small functions of lanes must not become calls: their arguments would travel through memory. A GPU's compiler decides
// for itself, and has to be told what runs on the device; sanitizers take minutes to instrument what is inlined into
// one function.
#if defined(__CUDACC__)
#define PHYSMAS_HOST_DEVICE __host__ __device__
#define PHYSMAS_INLINE __host__ __device__ inline
#define PHYSMAS_LAMBDA_INLINE
#define PHYSMAS_CALL __host__ __device__ __noinline__
#elif defined(__SANITIZE_ADDRESS__)
#define PHYSMAS_HOST_DEVICE
#define PHYSMAS_INLINE inline
#define PHYSMAS_LAMBDA_INLINE
#define PHYSMAS_CALL __attribute__((noinline))
#else
#define PHYSMAS_HOST_DEVICE
#define PHYSMAS_INLINE inline __attribute__((always_inline))
#define PHYSMAS_LAMBDA_INLINE __attribute__((always_inline))
#define PHYSMAS_CALL __attribute__((noinline))
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
template <class T>
constexpr Scalar<T> kSmallest = std::numeric_limits<Scalar<T>>::min();  // normal number
// Far above the smallest normal number, so that its square root and its reciprocal stay ordinary numbers.
template <class T>
constexpr Scalar<T> kTiny = Scalar<T>(1e4) * kSmallest<T>;

template <int K, class T>
PHYSMAS_INLINE T power(const T& x) {
  if constexpr (K == 1)
    return x;
  else {
    const T root = power<K / 2>(x);
    return root * root;
  }
}
template <int From, int Count, class T, int N>
PHYSMAS_INLINE T polynomial_part(const T& x, const double (&c)[N]) {
  if constexpr (Count == 1)
    return T(static_cast<Scalar<T>>(c[From]));
  else {
    constexpr int kLow = Count <= 2 ? 1 : Count <= 4 ? 2 : Count <= 8 ? 4 : 8;
    return polynomial_part<From, kLow>(x, c) + power<kLow>(x) * polynomial_part<From + kLow, Count - kLow>(x, c);
  }
}
// Σ c_k x^k by pairs of terms, pairs of pairs and so on (Estrin's scheme), since the formulas here wait more than they
// work: no multiplication waits for more than log2 N others.
template <class T, int N>
PHYSMAS_INLINE T polynomial(const T& x, const double (&c)[N]) {
  static_assert(N <= 16);
  return polynomial_part<0, N>(x, c);
}

// (exp(x) − 1) / x for |x| <= log(2) / 2, within 4 ulp.
template <class T>
PHYSMAS_INLINE T exponential_less_one_over(const T& x) {
  if constexpr (sizeof(Scalar<T>) == 4) {
    return polynomial(x, {1.0, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040});
  } else {
    return polynomial(x, {1.0, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880,
                          1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800});
  }
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
