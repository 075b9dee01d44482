// The unit of work of grid transfers: three neighbouring nodes along z, four numbers each (plus a fourth node that
// always has weight zero), 16 numbers in as few registers as the target allows. One particle touches nine of them.
#ifndef PHYSMAS_MPM_CPU_NODE_ROW_H
#define PHYSMAS_MPM_CPU_NODE_ROW_H

#include <cstring>
#include <utility>

#include "mpm/math/scalar.h"

namespace physmas::mpm {

#if defined(__AVX512F__)
constexpr int kRegisterBytes = 64;
#elif defined(__AVX__)
constexpr int kRegisterBytes = 32;
#else
constexpr int kRegisterBytes = 16;
#endif

template <class T>
struct NodeRow {
  static constexpr int kPart = kRegisterBytes / static_cast<int>(sizeof(T));  // numbers per register
  static constexpr int kParts = 16 / kPart;
  typedef T Part __attribute__((vector_size(kRegisterBytes)));
  Part part[kParts];

  PHYSMAS_INLINE static NodeRow load(const T* p) {
    NodeRow r;
    std::memcpy(&r.part, p, sizeof(r.part));
    return r;
  }
  PHYSMAS_INLINE void store(T* p) const { std::memcpy(p, &part, sizeof(part)); }
  PHYSMAS_INLINE static NodeRow zero() {
    NodeRow r;
    for (int i = 0; i < kParts; ++i) r.part[i] = Part{};
    return r;
  }
  // The four numbers of node k at every node.
  template <int k>
  PHYSMAS_INLINE NodeRow repeat() const {
    NodeRow r;
    repeat_into<k>(r, std::make_index_sequence<kPart>());
    return r;
  }
  // 1 in the four numbers of node k, 0 elsewhere.
  template <int k>
  PHYSMAS_INLINE static NodeRow unit() {
    NodeRow r;
    fill_unit<k>(r, std::make_index_sequence<kPart>());
    return r;
  }
  // The sums over the nodes of a, b, c and d, one sum per node of the result. Node 3 must be zero.
  PHYSMAS_INLINE static NodeRow sums_of_nodes(const NodeRow& a, const NodeRow& b, const NodeRow& c, const NodeRow& d) {
    NodeRow r;
    if constexpr (kParts == 1) {
      const Part ab =
          __builtin_shufflevector(a.part[0], b.part[0], 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
          __builtin_shufflevector(a.part[0], b.part[0], 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
      const Part cd =
          __builtin_shufflevector(c.part[0], d.part[0], 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
          __builtin_shufflevector(c.part[0], d.part[0], 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
      r.part[0] = __builtin_shufflevector(ab, cd, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27) +
                  __builtin_shufflevector(ab, cd, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31);
    } else if constexpr (kParts == 2) {
      const Part p[4] = {a.part[0] + a.part[1], b.part[0] + b.part[1], c.part[0] + c.part[1], d.part[0] + d.part[1]};
      for (int i = 0; i < 2; ++i) {
        r.part[i] = __builtin_shufflevector(p[2 * i], p[2 * i + 1], 0, 1, 2, 3, 8, 9, 10, 11) +
                    __builtin_shufflevector(p[2 * i], p[2 * i + 1], 4, 5, 6, 7, 12, 13, 14, 15);
      }
    } else {
      // Parts of one node or of half a node.
      constexpr int kStep = kParts / 4;
      const NodeRow* all[4] = {&a, &b, &c, &d};
      for (int i = 0; i < kParts; ++i) {
        const Part* p = all[i / kStep]->part + i % kStep;
        r.part[i] = p[0] + p[kStep] + p[2 * kStep];
      }
    }
    return r;
  }

 private:
  template <int k, size_t... I>
  PHYSMAS_INLINE void repeat_into(NodeRow& r, std::index_sequence<I...>) const {
    for (int p = 0; p < kParts; ++p) {
      // Where node k's numbers lie: inside one part, or, where a part is half a node, in two.
      const Part& from = part[kPart >= 4 ? 4 * k / kPart : 2 * k + p % 2];
      constexpr int at = kPart >= 4 ? 4 * k % kPart : 0;
      r.part[p] = __builtin_shufflevector(from, from, (at + I % (kPart >= 4 ? 4 : kPart))...);
    }
  }
  template <int k, size_t... I>
  PHYSMAS_INLINE static void fill_unit(NodeRow& r, std::index_sequence<I...>) {
    for (int p = 0; p < kParts; ++p) r.part[p] = Part{((p * kPart + static_cast<int>(I)) / 4 == k ? T(1) : T(0))...};
  }
};

template <class T>
PHYSMAS_INLINE NodeRow<T> operator+(const NodeRow<T>& a, const NodeRow<T>& b) {
  NodeRow<T> r;
  for (int i = 0; i < NodeRow<T>::kParts; ++i) r.part[i] = a.part[i] + b.part[i];
  return r;
}
template <class T>
PHYSMAS_INLINE NodeRow<T> operator-(const NodeRow<T>& a, const NodeRow<T>& b) {
  NodeRow<T> r;
  for (int i = 0; i < NodeRow<T>::kParts; ++i) r.part[i] = a.part[i] - b.part[i];
  return r;
}
template <class T>
PHYSMAS_INLINE NodeRow<T> operator*(const NodeRow<T>& a, const NodeRow<T>& b) {
  NodeRow<T> r;
  for (int i = 0; i < NodeRow<T>::kParts; ++i) r.part[i] = a.part[i] * b.part[i];
  return r;
}
template <class T>
PHYSMAS_INLINE NodeRow<T> operator*(T s, const NodeRow<T>& a) {
  NodeRow<T> r;
  for (int i = 0; i < NodeRow<T>::kParts; ++i) r.part[i] = s * a.part[i];
  return r;
}

// A product that is rounded here and used in several sums: otherwise the compiler multiplies once per sum in order to
// fuse, which costs more than it saves.
template <class Part>
PHYSMAS_INLINE Part rounded_part(Part a) {
#if defined(__x86_64__)
  __asm__("" : "+v"(a));
#endif
  return a;
}
template <class T>
PHYSMAS_INLINE NodeRow<T> rounded(NodeRow<T> a) {
  for (int i = 0; i < NodeRow<T>::kParts; ++i) a.part[i] = rounded_part(a.part[i]);
  return a;
}

// Transposes a square of registers: entry k of register i becomes entry i of register k.
template <class Part, int kSize, int kStep, size_t... I>
PHYSMAS_INLINE void transpose_step(Part* r, std::index_sequence<I...>) {
  for (int i = 0; i < kSize; ++i) {
    if (i & kStep) continue;
    const Part a = r[i], b = r[i + kStep];
    r[i] = __builtin_shufflevector(a, b, ((I & kStep) ? I - kStep + kSize : I)...);
    r[i + kStep] = __builtin_shufflevector(a, b, ((I & kStep) ? I + kSize : I + kStep)...);
  }
}
template <class Part, int kSize, int kStep = 1>
PHYSMAS_INLINE void transpose_registers(Part* r) {
  transpose_step<Part, kSize, kStep>(r, std::make_index_sequence<kSize>());
  if constexpr (2 * kStep < kSize) transpose_registers<Part, kSize, 2 * kStep>(r);
}

// records[l][k] → lanes[k][l] for L records of 16 numbers, L the numbers in a register; and the way back.
template <class T>
PHYSMAS_INLINE void records_to_lanes(const T (*records)[16], T (*lanes)[NodeRow<T>::kPart]) {
  constexpr int L = NodeRow<T>::kPart;
  for (int first = 0; first < 16; first += L) {
    typename NodeRow<T>::Part r[L];
    for (int l = 0; l < L; ++l) std::memcpy(&r[l], &records[l][first], sizeof(r[l]));
    transpose_registers<typename NodeRow<T>::Part, L>(r);
    for (int k = 0; k < L; ++k) std::memcpy(&lanes[first + k], &r[k], sizeof(r[k]));
  }
}
template <class T>
PHYSMAS_INLINE void lanes_to_records(const T (*lanes)[NodeRow<T>::kPart], T (*records)[16]) {
  constexpr int L = NodeRow<T>::kPart;
  for (int first = 0; first < 16; first += L) {
    typename NodeRow<T>::Part r[L];
    for (int k = 0; k < L; ++k) std::memcpy(&r[k], &lanes[first + k], sizeof(r[k]));
    transpose_registers<typename NodeRow<T>::Part, L>(r);
    for (int l = 0; l < L; ++l) std::memcpy(&records[l][first], &r[l], sizeof(r[l]));
  }
}

}  // namespace physmas::mpm

#endif
