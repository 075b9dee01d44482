// What travels between a register of particles and the grid.
#ifndef PHYSMAS_MPM_CPU_GRID_NUMBERS_H
#define PHYSMAS_MPM_CPU_GRID_NUMBERS_H

#include "mpm/cpu/place.h"

namespace physmas::mpm {

// A vector and a matrix per lane. From the grid: the velocity v, and its first moments about the particle
// Σ w v (node − particle) [cells]. To the grid: P and Q, of which a node gets w (P + Q (node − centre node)), and the
// mass. The numbers of a lane, one below the other, are the record that transfers of one particle work with.
template <class T>
struct GridNumbers {
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;
  // Mass; vector; then for every column of the matrix a number without meaning (to the grid: zero) and the column.
  alignas(64) T number[16][W];
  alignas(64) T weight[9][W];  // of the stencil's nodes along x, y and z

  static constexpr int kMass = 0;
  static constexpr int vector(int a) { return 1 + a; }
  static constexpr int matrix(int a, int b) { return 5 + 4 * b + a; }

  PHYSMAS_INLINE V get(int k) const { return V(number[k], stdx::vector_aligned); }
  PHYSMAS_INLINE void set(int k, const V& lanes) { lanes.copy_to(number[k], stdx::vector_aligned); }
  PHYSMAS_INLINE void set_weights(const Place<V>& at) {
    for (int k = 0; k < 9; ++k) at.weight[k / 3][k % 3].copy_to(weight[k], stdx::vector_aligned);
  }
  PHYSMAS_INLINE void set(const V& mass, const Vec3<V>& vector_lanes, const Mat3<V>& matrix_lanes) {
    set(kMass, mass);
    for (int a = 0; a < 3; ++a) {
      set(vector(a), vector_lanes[a]);
      for (int b = 0; b < 3; ++b) set(matrix(a, b), matrix_lanes[a][b]);
    }
  }
};

}  // namespace physmas::mpm

#endif
