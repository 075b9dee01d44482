// The unit of work of grid transfers: three neighbouring nodes along z, four numbers each (plus a fourth node that
// always has weight zero), 16 numbers in as few registers as the target allows. One particle touches nine such rows.
#ifndef PHYSMAS_MPM_ROW_H
#define PHYSMAS_MPM_ROW_H

#include <cstring>
#include <utility>

namespace physmas::mpm {

#if defined(__AVX512F__)
constexpr int kRegisterBytes = 64;
#elif defined(__AVX__)
constexpr int kRegisterBytes = 32;
#else
constexpr int kRegisterBytes = 16;
#endif

#define PHYSMAS_INLINE inline __attribute__((always_inline))

template <class T>
struct Row {
  static constexpr int kPart = kRegisterBytes / static_cast<int>(sizeof(T));  // numbers per register
  static constexpr int kParts = 16 / kPart;
  typedef T Part __attribute__((vector_size(kRegisterBytes)));
  typedef T Quad __attribute__((vector_size(4 * sizeof(T))));  // one node
  Part part[kParts];

  PHYSMAS_INLINE static Row load(const T* p) {
    Row r;
    std::memcpy(&r.part, p, sizeof(r.part));
    return r;
  }
  PHYSMAS_INLINE void store(T* p) const { std::memcpy(p, &part, sizeof(part)); }
  PHYSMAS_INLINE static Row zero() {
    Row r;
    for (int i = 0; i < kParts; ++i) r.part[i] = Part{};
    return r;
  }
  // The same four numbers at each node.
  PHYSMAS_INLINE static Row repeat(const T* quad) {
    Row r;
    fill<0>(r, quad, std::make_index_sequence<kPart>());
    return r;
  }
  // quad[k] in all four numbers of node k.
  PHYSMAS_INLINE static Row spread(const T* quad) {
    Row r;
    fill<1>(r, quad, std::make_index_sequence<kPart>());
    return r;
  }
  // Sum over the first three nodes: four numbers.
  PHYSMAS_INLINE Quad sum_of_nodes() const { return node<0>() + node<1>() + node<2>(); }

 private:
  template <int kMode, size_t... I>
  PHYSMAS_INLINE static void fill(Row& r, const T* quad, std::index_sequence<I...>) {
    Quad q;
    std::memcpy(&q, quad, sizeof(q));
    for (int p = 0; p < kParts; ++p) {
      const int first = p * kPart;
      if constexpr (kParts == 1) {
        r.part[p] = kMode == 0 ? __builtin_shufflevector(q, q, (I % 4)...) : __builtin_shufflevector(q, q, (I / 4)...);
      } else {
        r.part[p] = kMode == 0 ? Part{quad[(first + I) % 4]...} : Part{quad[(first + I) / 4]...};
      }
    }
  }
  template <int k>
  PHYSMAS_INLINE Quad node() const {
    if constexpr (kPart >= 4) {
      constexpr int at = 4 * k % kPart;
      const Part& p = part[4 * k / kPart];
      return __builtin_shufflevector(p, p, at, at + 1, at + 2, at + 3);
    } else {
      return __builtin_shufflevector(part[2 * k], part[2 * k + 1], 0, 1, 2, 3);
    }
  }
};

template <class T>
PHYSMAS_INLINE Row<T> operator+(const Row<T>& a, const Row<T>& b) {
  Row<T> r;
  for (int i = 0; i < Row<T>::kParts; ++i) r.part[i] = a.part[i] + b.part[i];
  return r;
}
template <class T>
PHYSMAS_INLINE Row<T> operator-(const Row<T>& a, const Row<T>& b) {
  Row<T> r;
  for (int i = 0; i < Row<T>::kParts; ++i) r.part[i] = a.part[i] - b.part[i];
  return r;
}
template <class T>
PHYSMAS_INLINE Row<T> operator*(const Row<T>& a, const Row<T>& b) {
  Row<T> r;
  for (int i = 0; i < Row<T>::kParts; ++i) r.part[i] = a.part[i] * b.part[i];
  return r;
}
template <class T>
PHYSMAS_INLINE Row<T> operator*(T s, const Row<T>& a) {
  Row<T> r;
  for (int i = 0; i < Row<T>::kParts; ++i) r.part[i] = s * a.part[i];
  return r;
}

}  // namespace physmas::mpm

#endif
