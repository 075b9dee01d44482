// SIMD lanes of numbers, one particle per lane: the same operations as in scalar.h.
#ifndef PHYSMAS_MPM_MATH_LANES_H
#define PHYSMAS_MPM_MATH_LANES_H

#include <cstdint>
#include <cstring>

// GCC 12 takes the deliberately undefined registers inside its own AVX-512 headers for a mistake of ours (PR 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <experimental/simd>
#pragma GCC diagnostic pop

#if defined(__clang__) && defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "mpm/math/scalar.h"

namespace physmas::mpm {

namespace stdx = std::experimental;

// As many numbers as one register of the target holds.
template <class T>
using Lanes = stdx::native_simd<T>;
template <class T>
constexpr int kLanes = static_cast<int>(Lanes<T>::size());

template <class T>
struct ScalarOf<stdx::simd<T, stdx::simd_abi::native<T>>> {
  using Type = T;
};

// The same bytes as another type.
template <class To, class From>
PHYSMAS_INLINE To same_bytes(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(static_cast<void*>(&to), static_cast<const void*>(&from), sizeof(To));
  return to;
}

// Bit l: lane l.
using LaneBits = unsigned;
template <class T>
constexpr LaneBits kAllLanes = (LaneBits(1) << kLanes<T>)-1;

template <class T, class Abi>
PHYSMAS_INLINE LaneBits lane_bits(const stdx::simd_mask<T, Abi>& mask) {
  if constexpr (sizeof(mask) == 2 && stdx::simd_mask<T, Abi>::size() == 16) {
    return same_bytes<std::uint16_t>(mask);
  } else if constexpr (sizeof(mask) == 1) {
    return same_bytes<std::uint8_t>(mask);
  } else {
    LaneBits bits = 0;
    for (size_t l = 0; l < mask.size(); ++l) bits |= LaneBits(mask[l]) << l;
    return bits;
  }
}
template <class T>
PHYSMAS_INLINE typename Lanes<T>::mask_type lane_mask(LaneBits bits) {
  using Mask = typename Lanes<T>::mask_type;
  if constexpr (sizeof(Mask) == 2 && kLanes<T> == 16) {
    return same_bytes<Mask>(static_cast<std::uint16_t>(bits));
  } else if constexpr (sizeof(Mask) == 1) {
    return same_bytes<Mask>(static_cast<std::uint8_t>(bits));
  } else {
    Mask mask(false);
    for (int l = 0; l < kLanes<T>; ++l) mask[l] = bits >> l & 1;
    return mask;
  }
}

template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> select(const stdx::simd_mask<T, Abi>& condition, const stdx::simd<T, Abi>& yes,
                                         const stdx::simd<T, Abi>& no) {
#if defined(__clang__) && defined(__AVX512F__)
  // Under clang masked assignment of libstdc++ 12 does nothing where masks are bits.
  static_assert(sizeof(yes) == 64);
  if constexpr (sizeof(T) == 4) {
    return same_bytes<stdx::simd<T, Abi>>(
        _mm512_mask_blend_ps(same_bytes<std::uint16_t>(condition), same_bytes<__m512>(no), same_bytes<__m512>(yes)));
  } else {
    return same_bytes<stdx::simd<T, Abi>>(
        _mm512_mask_blend_pd(same_bytes<std::uint8_t>(condition), same_bytes<__m512d>(no), same_bytes<__m512d>(yes)));
  }
#else
  stdx::simd<T, Abi> result = no;
  stdx::where(condition, result) = yes;
  return result;
#endif
}
// The compiler's own vector of the same size: its comparisons compile to one maximum or minimum.
template <class T, class Abi>
using RawVector __attribute__((vector_size(sizeof(stdx::simd<T, Abi>)))) = T;

template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> at_least(const stdx::simd<T, Abi>& x, const stdx::simd<T, Abi>& low) {
  const auto a = same_bytes<RawVector<T, Abi>>(x), b = same_bytes<RawVector<T, Abi>>(low);
  return same_bytes<stdx::simd<T, Abi>>(RawVector<T, Abi>(a > b ? a : b));
}
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> at_most(const stdx::simd<T, Abi>& x, const stdx::simd<T, Abi>& high) {
  const auto a = same_bytes<RawVector<T, Abi>>(x), b = same_bytes<RawVector<T, Abi>>(high);
  return same_bytes<stdx::simd<T, Abi>>(RawVector<T, Abi>(a < b ? a : b));
}
template <class T, class Abi>
PHYSMAS_INLINE bool all(const stdx::simd_mask<T, Abi>& condition) {
  return stdx::all_of(condition);
}
template <class T, class Abi>
PHYSMAS_INLINE bool any(const stdx::simd_mask<T, Abi>& condition) {
  return stdx::any_of(condition);
}
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> square_root(const stdx::simd<T, Abi>& x) {
  return stdx::sqrt(x);
}
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> absolute(const stdx::simd<T, Abi>& x) {
  return stdx::abs(x);
}
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> round_down(const stdx::simd<T, Abi>& x) {
  return stdx::floor(x);
}

// How a floating-point number is stored, for taking it apart and putting it together.
template <class T>
struct FloatBits;
template <>
struct FloatBits<float> {
  using Int = std::int32_t;
  static constexpr int kMantissa = 23;
  static constexpr Int kBias = 127;
  static constexpr Int kHalf = 0x3f000000;  // the bits of 0.5
};
template <>
struct FloatBits<double> {
  using Int = std::int64_t;
  static constexpr int kMantissa = 52;
  static constexpr Int kBias = 1023;
  static constexpr Int kHalf = 0x3fe0000000000000;
};

// Natural logarithm of positive normal numbers, within 2 ulp, of m 2^e with m in [sqrt(1/2), sqrt(2)): exact at 1, and
// the relative error stays small next to 1, where strains are tiny. For float f − f²/2 + f³ times a polynomial,
// f = m − 1: divisions are the slowest part of a Hencky step; for double 2 atanh((m − 1) / (m + 1)).
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> natural_log(const stdx::simd<T, Abi>& x) {
  using V = stdx::simd<T, Abi>;
  using Bits = FloatBits<T>;
  using Int = typename Bits::Int;
  typedef T FloatVector __attribute__((vector_size(sizeof(V))));
  typedef Int IntVector __attribute__((vector_size(sizeof(V))));
  const IntVector bits = same_bytes<IntVector>(x);
  const Int mask = (Int{1} << Bits::kMantissa) - 1;
  const IntVector exponent = (bits >> Bits::kMantissa) - (Bits::kBias - 1);
  const IntVector mantissa = (bits & mask) | Bits::kHalf;
  V e = same_bytes<V>(__builtin_convertvector(exponent, FloatVector));
  V m = same_bytes<V>(mantissa);
  const auto low = m < V(T(0.70710678118654752440));
  m = select(low, m + m, m);
  e = select(low, e - V(T(1)), e);
  const V f = m - T(1);
  constexpr T kLogTwoHigh = sizeof(T) == 4 ? T(0.693359375) : T(6.93145751953125e-1);
  constexpr T kLogTwoLow = sizeof(T) == 4 ? T(-2.12194440e-4) : T(1.42860682030941723212e-6);
  if constexpr (sizeof(T) == 4) {
    // Interpolated at Chebyshev nodes.
    const V rest = polynomial(f, {0.333333307, -0.250003064, 0.200010451, -0.166412815, 0.142144958, -0.129981835,
                                  0.126223209, -0.079027459});
    return e * kLogTwoHigh + (f + (f * f * (rest * f - T(0.5)) + e * kLogTwoLow));
  } else {
    const V s = f / (m + T(1));
    const V z = s * s;
    constexpr int kTerms = 10;
    V sum(T(2) / T(2 * kTerms + 1));
    for (int k = kTerms - 1; k >= 1; --k) sum = sum * z + V(T(2) / T(2 * k + 1));
    return e * kLogTwoHigh + (s + s + (s * z * sum + e * kLogTwoLow));
  }
}

// x^(−1/3) of positive normal numbers, within 3 ulp. A third of the exponent is taken on the bits as an integer, which
// is within 4 %; each step of y ← y (1 + h/3 + 2 h²/9), h = 1 − x y³, triples the digits.
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> inverse_cube_root(const stdx::simd<T, Abi>& x) {
  using V = stdx::simd<T, Abi>;
  using Bits = FloatBits<T>;
  using Int = typename Bits::Int;
  typedef T FloatVector __attribute__((vector_size(sizeof(V))));
  typedef Int IntVector __attribute__((vector_size(sizeof(V))));
  constexpr double kOne = static_cast<double>(Int{1} << Bits::kMantissa);
  const FloatVector bits = __builtin_convertvector(same_bytes<IntVector>(x), FloatVector);
  const FloatVector guess = T(4.0 / 3.0 * (Bits::kBias - 0.045) * kOne) - T(1.0 / 3.0) * bits;
  V y = same_bytes<V>(__builtin_convertvector(guess, IntVector));
  constexpr int kSteps = sizeof(T) == 4 ? 2 : 3;
  for (int k = 0; k < kSteps; ++k) {
    const V h = T(1) - x * y * (y * y);
    y = y + y * h * (T(1.0 / 3.0) + T(2.0 / 9.0) * h);
  }
  return y;
}

// Exponential function within 2 ulp; arguments are cut to the range whose result is a normal number.
template <class T, class Abi>
PHYSMAS_INLINE stdx::simd<T, Abi> exponential(const stdx::simd<T, Abi>& x) {
  using V = stdx::simd<T, Abi>;
  using Bits = FloatBits<T>;
  using Int = typename Bits::Int;
  typedef T FloatVector __attribute__((vector_size(sizeof(V))));
  typedef Int IntVector __attribute__((vector_size(sizeof(V))));
  constexpr T kLimit = sizeof(T) == 4 ? T(87) : T(708);
  const V above = select(x > V(-kLimit), x, V(-kLimit));
  const V y = select(above < V(kLimit), above, V(kLimit));
  const V n = stdx::floor(y * T(1.44269504088896340736) + T(0.5));
  constexpr T kLogTwoHigh = sizeof(T) == 4 ? T(0.693359375) : T(6.93145751953125e-1);
  constexpr T kLogTwoLow = sizeof(T) == 4 ? T(-2.12194440e-4) : T(1.42860682030941723212e-6);
  const V r = (y - n * kLogTwoHigh) - n * kLogTwoLow;
  const V sum = T(1) + r * exponential_less_one_over(r);
  const IntVector exponent = __builtin_convertvector(same_bytes<FloatVector>(n), IntVector) + Bits::kBias;
  return sum * same_bytes<V>(exponent << Bits::kMantissa);
}

}  // namespace physmas::mpm

#endif
