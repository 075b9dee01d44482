// The few operations that the solver's formulas need, for plain numbers, under names that SIMD lanes share (lanes.h).
#ifndef PHYSMAS_MPM_SCALAR_H
#define PHYSMAS_MPM_SCALAR_H

#include <cmath>
#include <limits>

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

inline float select(bool condition, float yes, float no) {
  return condition ? yes : no;
}
inline double select(bool condition, double yes, double no) {
  return condition ? yes : no;
}
inline bool all(bool condition) {
  return condition;
}
inline bool any(bool condition) {
  return condition;
}

inline float square_root(float x) {
  return std::sqrt(x);
}
inline double square_root(double x) {
  return std::sqrt(x);
}
inline float absolute(float x) {
  return std::fabs(x);
}
inline double absolute(double x) {
  return std::fabs(x);
}
inline float natural_log(float x) {
  return std::log(x);
}
inline double natural_log(double x) {
  return std::log(x);
}
inline float exponential(float x) {
  return std::exp(x);
}
inline double exponential(double x) {
  return std::exp(x);
}
inline float round_down(float x) {
  return std::floor(x);
}
inline double round_down(double x) {
  return std::floor(x);
}

}  // namespace physmas::mpm

#endif
