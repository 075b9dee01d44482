// Several floats at once, as many as a register of the target holds. (GCC takes comparisons of wider vectors apart,
// number by number.)
#ifndef PHYSMAS_SPLAT_LANES_H
#define PHYSMAS_SPLAT_LANES_H

#include <cstdint>
#include <cstring>

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace physmas::splat {

#if defined(__AVX512F__)
constexpr int kLanes = 16;
#elif defined(__AVX2__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
typedef float Lanes __attribute__((vector_size(4 * kLanes)));
typedef int32_t LaneMask __attribute__((vector_size(4 * kLanes)));  // -1 where true, 0 where false

// Vectors go in and out by reference: how they are passed by value depends on the target, and compilers warn of it.

// Keeps the lanes of `a` where the mask is true and makes the others +0.
inline void keep(const LaneMask& mask, Lanes* a) {
  *a = reinterpret_cast<Lanes>(mask & reinterpret_cast<LaneMask>(*a));
}

inline bool any(const LaneMask& mask) {
#if defined(__AVX512F__)
  const __m512i m = reinterpret_cast<__m512i>(mask);
  return _mm512_test_epi32_mask(m, m) != 0;
#else
  uint64_t words[kLanes / 2], all = 0;
  std::memcpy(words, &mask, sizeof(words));
  for (uint64_t word : words) all |= word;
  return all != 0;
#endif
}

// *p becomes 2^p for p <= 0, relative error below 3e-7; p under -30 counts as -30.
inline void exp2_nonpositive(Lanes* exponent) {
  const Lanes low = Lanes{} - 30.0f;
  const Lanes p = *exponent > low ? *exponent : low;
  // Adding 1.5 * 2^23 leaves the nearest integer in the lowest bits of the mantissa.
  const Lanes magic = Lanes{} + 12582912.0f;
  const Lanes shifted = p + magic;
  const Lanes f = p - (shifted - magic);  // -0.5..0.5
  // Taylor series of 2^f to degree 6: the rest is below 1.3e-7 there.
  Lanes y = Lanes{} + 1.5403530e-4f;
  y = y * f + 1.3333558e-3f;
  y = y * f + 9.6181291e-3f;
  y = y * f + 5.5504109e-2f;
  y = y * f + 2.4022651e-1f;
  y = y * f + 6.9314718e-1f;
  y = y * f + 1.0f;
  const LaneMask whole = reinterpret_cast<LaneMask>(shifted) - reinterpret_cast<LaneMask>(magic);
  *exponent = reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(y) + (whole << 23));
}

}  // namespace physmas::splat

#endif
