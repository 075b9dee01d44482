// Transfers between a particle and the tile of nodes around its block (layout.h).
#ifndef PHYSMAS_MPM_CUDA_TILE_H
#define PHYSMAS_MPM_CUDA_TILE_H

#include "mpm/cuda/layout.h"
#include "mpm/math/mat3.h"

namespace physmas::mpm::PHYSMAS_GPU {

// Distances between nodes in shared memory: those of neighbouring cells lie in different banks.
constexpr int kVelocityY = 12, kVelocityX = 96, kVelocityTile = kTile * kVelocityX;
constexpr int kSumY = 8, kSumX = 68, kSumTile = kTile * kSumX;

// Quadratic B-splines (Steffen et al. 2008) of a particle at x [cells from the block's first node].
template <class T>
struct Stencil {
  int base[3];                   // lowest node
  T weight[3][3], offset[3][3];  // per axis and node; offset: node − particle [cells]
};

// The base is held inside the tile, so that no number whatsoever can lead a transfer outside it; where that bites, the
// check of speeds ends the run.
template <class T>
PHYSMAS_DEVICE Stencil<T> stencil_of(const Vec3<T>& x) {
  Stencil<T> s;
  for (int axis = 0; axis < 3; ++axis) {
    const T base = at_most(at_least(round_down(x[axis] - T(0.5)), T(-1)), T(kCells));
    s.base[axis] = static_cast<int>(base);
    const T f = x[axis] - base, l = T(1.5) - f, r = f - T(0.5);
    s.weight[axis][0] = T(0.5) * l * l;
    s.weight[axis][2] = T(0.5) * r * r;
    s.weight[axis][1] = T(1) - s.weight[axis][0] - s.weight[axis][2];
    for (int k = 0; k < 3; ++k) s.offset[axis][k] = T(k) - f;
  }
  return s;
}

// Σ w u and Σ w u offsetᵀ [m/s, m/s cells], axis by axis. tile: velocities.
template <class T>
PHYSMAS_DEVICE void gather(const NodeVelocity<T>* tile, const Stencil<T>& s, Vec3<T>& v, Mat3<T>& moment) {
  const NodeVelocity<T>* const first =
      tile + (s.base[0] + 1) * kVelocityX + (s.base[1] + 1) * kVelocityY + (s.base[2] + 1);
  T sum[3] = {}, along[3][3] = {};  // along[axis][component]
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    T plane[3] = {}, plane_y[3] = {}, plane_z[3] = {};
#pragma unroll
    for (int j = 0; j < 3; ++j) {
      T line[3] = {}, line_z[3] = {};
#pragma unroll
      for (int k = 0; k < 3; ++k) {
        const NodeVelocity<T> node = first[i * kVelocityX + j * kVelocityY + k];
        const T w = s.weight[2][k], m = w * s.offset[2][k];
        for (int c = 0; c < 3; ++c) line[c] += w * node.u[c], line_z[c] += m * node.u[c];
      }
      const T w = s.weight[1][j], m = w * s.offset[1][j];
      for (int c = 0; c < 3; ++c) plane[c] += w * line[c], plane_z[c] += w * line_z[c], plane_y[c] += m * line[c];
    }
    const T w = s.weight[0][i], m = w * s.offset[0][i];
    for (int c = 0; c < 3; ++c) {
      sum[c] += w * plane[c];
      along[0][c] += m * plane[c], along[1][c] += w * plane_y[c], along[2][c] += w * plane_z[c];
    }
  }
  for (int c = 0; c < 3; ++c) {
    v[c] = sum[c];
    for (int axis = 0; axis < 3; ++axis) moment[c][axis] = along[axis][c];
  }
}

// What a particle brings to the grid: to a node w (momentum + slope · offset), w mass.
template <class T>
struct Gift {
  Vec3<T> momentum;  // kg m/s
  Mat3<T> slope;     // kg m/s per cell
  T mass;            // kg
};

// Calls give(i, j, k, momentum, mass) for the 27 nodes, counted from the base.
template <class T, class Give>
PHYSMAS_DEVICE void scatter(const Stencil<T>& s, const Gift<T>& gift, const Give& give) {
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    T plane[3];
    for (int c = 0; c < 3; ++c) plane[c] = gift.momentum[c] + gift.slope[c].x * s.offset[0][i];
#pragma unroll
    for (int j = 0; j < 3; ++j) {
      const T w = s.weight[0][i] * s.weight[1][j], mass = w * gift.mass;
      T line[3], step[3];
      for (int c = 0; c < 3; ++c) {
        line[c] = w * (plane[c] + gift.slope[c].y * s.offset[1][j]);
        step[c] = w * gift.slope[c].z;
      }
#pragma unroll
      for (int k = 0; k < 3; ++k) {
        const T weight = s.weight[2][k], m = weight * s.offset[2][k];
        const T momentum[3] = {weight * line[0] + m * step[0], weight * line[1] + m * step[1],
                               weight * line[2] + m * step[2]};
        give(i, j, k, momentum, weight * mass);
      }
    }
  }
}

// The largest power of two by which 256 numbers of at most `bound`, times a weight of at most 0.75³, may be scaled so
// that their sum fits an int; as the exponent, and the same as a number.
struct IntScale {
  int exponent;
  float scale;
};
constexpr int kMostInItem = 256;
PHYSMAS_DEVICE IntScale int_scale(unsigned bits_of_bound) {
  int biased = 277 - static_cast<int>(bits_of_bound >> 23);
  biased = biased < 2 ? 2 : biased > 252 ? 252 : biased;
  return {biased - 127, number_of(static_cast<unsigned>(biased) << 23)};
}
// sum × 2^shift, rounded.
PHYSMAS_DEVICE long long shifted(long long sum, int shift) {
  if (shift >= 0) return static_cast<long long>(static_cast<unsigned long long>(sum) << (shift < 63 ? shift : 63));
  return shift < -61 ? 0 : (sum + (1LL << (-shift - 1))) >> -shift;
}

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
