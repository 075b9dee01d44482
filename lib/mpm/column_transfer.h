// Transfers of a register of particles that fill a column of cells: neighbours along z, four particles each, so that
// lane 4 z + s is particle s of cell z. What a node of the stencil holds then lies in a row of nodes, in the right
// lanes but for one shuffle. All weights of a column's particles belong to the same 3 × 3 rows of nodes.
#ifndef PHYSMAS_MPM_COLUMN_TRANSFER_H
#define PHYSMAS_MPM_COLUMN_TRANSFER_H

#include "mpm/place.h"
#include "mpm/row_transfer.h"

namespace physmas::mpm {

// Particles per cell of a column, and cells per column (0: registers are too short for columns).
constexpr int kColumnSlots = 4;
template <class T>
constexpr int kColumnCells = kLanes<T> / kColumnSlots;

namespace column_detail {

template <class T>
using Part = typename Row<T>::Part;

template <class T>
PHYSMAS_INLINE Part<T> load(const T* p) {
  Part<T> a;
  std::memcpy(&a, p, sizeof(a));
  return a;
}
template <class T, class Vector>
PHYSMAS_INLINE void add_to(T* p, const Vector& a) {
  Vector sum;
  std::memcpy(&sum, p, sizeof(sum));
  sum += a;
  std::memcpy(p, &sum, sizeof(sum));
}

// Entry k of every group of four, four times.
template <int k, class P, size_t... I>
PHYSMAS_INLINE P spread(const P& a, std::index_sequence<I...>) {
  return __builtin_shufflevector(a, a, (I / 4 * 4 + k)...);
}

// Pairs of entries of a and b from every group of four; which entries is told by two tables that serve one
// instruction each: halves of 128 bits for float, every other entry for double.
template <bool kHigh, class T, class P, size_t... I>
PHYSMAS_INLINE P interleave(const P& a, const P& b, std::index_sequence<I...>) {
  constexpr int kSize = sizeof...(I);
  if constexpr (sizeof(T) == 4) {
    return __builtin_shufflevector(a, b, (int(I / 4 * 4 + I % 4 / 2 + 2 * kHigh) + (I % 2 ? kSize : 0))...);
  } else {
    return __builtin_shufflevector(a, b, (int(I / 2 * 2) + kHigh + (I % 2 ? kSize : 0))...);
  }
}
template <bool kHigh, class P, size_t... I>
PHYSMAS_INLINE P join_pairs(const P& ab, const P& cd, std::index_sequence<I...>) {
  constexpr int kSize = sizeof...(I);
  return __builtin_shufflevector(ab, cd, (int(I / 4 * 4 + I % 2) + 2 * kHigh + (I % 4 >= 2 ? kSize : 0))...);
}
// Sums over groups of four lanes of four registers: entry 4 z + c of the result is the sum of register c over cell z.
template <class T>
PHYSMAS_INLINE Part<T> sums_of_cells(const Part<T>& a, const Part<T>& b, const Part<T>& c, const Part<T>& d) {
  constexpr auto all = std::make_index_sequence<Row<T>::kPart>();
  const Part<T> ab = interleave<false, T>(a, b, all) + interleave<true, T>(a, b, all);
  const Part<T> cd = interleave<false, T>(c, d, all) + interleave<true, T>(c, d, all);
  return join_pairs<false>(ab, cd, all) + join_pairs<true>(ab, cd, all);
}

// Moves entries up by kBy, zeros below.
template <int kBy, class P, size_t... I>
PHYSMAS_INLINE P shifted_up(const P& a, std::index_sequence<I...>) {
  constexpr int kSize = sizeof...(I);
  return __builtin_shufflevector(P{}, a, (int(I) < kBy ? int(I) : kSize + int(I) - kBy)...);
}
// The two nodes beyond a column's own cells: kBy numbers of a leave the column.
template <int kBy, class Pair, class P, size_t... I>
PHYSMAS_INLINE Pair pushed_out(const P& a, std::index_sequence<I...>) {
  constexpr int kSize = sizeof(P) / sizeof(a[0]);
  return __builtin_shufflevector(a, P{}, (int(I) < kBy ? kSize - kBy + int(I) : kSize + int(I) % kSize)...);
}

// Velocity component kAxis and its first moments, as gather_particle has them.
template <int kAxis, class T>
PHYSMAS_INLINE void gather_component(const T* corner, const RowSteps& steps, const Part<T> (*w)[3], Lanes<T>& velocity,
                                     Vec3<Lanes<T>>& moment) {
  using P = Part<T>;
  constexpr auto all = std::make_index_sequence<Row<T>::kPart>();
  P total, first, along_x, along_y, along_z;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    P sum, low, slope, z;
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const T* row = corner + i * steps.x + j * steps.y;
      const P n0 = spread<kAxis + 1>(load(row), all), n1 = spread<kAxis + 1>(load(row + 4), all),
              n2 = spread<kAxis + 1>(load(row + 8), all);
      const P a = rounded_part(w[2][0] * n0);
      const P s = w[2][2] * n2 + (w[2][1] * n1 + a), d = w[2][2] * n2 - a;
      if (j == 0) {
        low = rounded_part(w[1][0] * s);
        sum = low, z = w[1][0] * d;
      } else {
        if (j == 2) slope = w[1][2] * s - low;
        sum = w[1][j] * s + sum, z = w[1][j] * d + z;
      }
    }
    if (i == 0) {
      first = rounded_part(w[0][0] * sum);
      total = first, along_y = w[0][0] * slope, along_z = w[0][0] * z;
    } else {
      if (i == 2) along_x = w[0][2] * sum - first;
      total = w[0][i] * sum + total, along_y = w[0][i] * slope + along_y, along_z = w[0][i] * z + along_z;
    }
  }
  using V = Lanes<T>;
  velocity = same_bytes<V>(total);
  moment = {same_bytes<V>(along_x), same_bytes<V>(along_y), same_bytes<V>(along_z)};
}

}  // namespace column_detail

// corner: the node at the base of the column's lowest cell. velocity and moment (row a: the first moments
// Σ w v_a (node − centre node) along x, y, z in cells) of all lanes.
template <class T>
PHYSMAS_INLINE void gather_column(const T* corner, const RowSteps& steps, const Place<Lanes<T>>& at,
                                  Vec3<Lanes<T>>& velocity, Mat3<Lanes<T>>& moment) {
  column_detail::Part<T> w[3][3];
  std::memcpy(&w, &at.weight, sizeof(w));
  column_detail::gather_component<0>(corner, steps, w, velocity.x, moment[0]);
  column_detail::gather_component<1>(corner, steps, w, velocity.y, moment[1]);
  column_detail::gather_component<2>(corner, steps, w, velocity.z, moment[2]);
}

// Adds w {m, P + Q (node − centre node)} of all lanes to the grid.
template <class T>
PHYSMAS_INLINE void scatter_column(T* corner, const RowSteps& steps, const Place<Lanes<T>>& at, const Lanes<T>& mass,
                                   const Vec3<Lanes<T>>& momentum, const Mat3<Lanes<T>>& Q) {
  using namespace column_detail;
  using P = Part<T>;
  constexpr int kSize = Row<T>::kPart;
  typedef T Pair __attribute__((vector_size(8 * sizeof(T))));
  constexpr auto all = std::make_index_sequence<kSize>();
  constexpr auto pair = std::make_index_sequence<8>();
  P w[3][3], p[3], q[3][3];
  std::memcpy(&w, &at.weight, sizeof(w));
  std::memcpy(&p, &momentum, sizeof(p));
  std::memcpy(&q, &Q, sizeof(q));
  const P m = same_bytes<P>(mass);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    P plane[3], step_y[3], step_z[3];
    const P plane_mass = w[0][i] * m;
#pragma GCC unroll 3
    for (int a = 0; a < 3; ++a) {
      plane[a] = rounded_part(w[0][i] * (i == 0 ? p[a] - q[a][0] : i == 1 ? p[a] : p[a] + q[a][0]));
      step_y[a] = rounded_part(w[0][i] * q[a][1]), step_z[a] = w[0][i] * q[a][2];
    }
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      P row[3], step[3];
      const P row_mass = w[1][j] * plane_mass;
#pragma GCC unroll 3
      for (int a = 0; a < 3; ++a) {
        row[a] = rounded_part(w[1][j] * (j == 0 ? plane[a] - step_y[a] : j == 1 ? plane[a] : plane[a] + step_y[a]));
        step[a] = rounded_part(w[1][j] * step_z[a]);
      }
      P node[3];
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) {
        P n[3];
#pragma GCC unroll 3
        for (int a = 0; a < 3; ++a) {
          n[a] = rounded_part(w[2][k] * (k == 0 ? row[a] - step[a] : k == 1 ? row[a] : row[a] + step[a]));
        }
        node[k] = sums_of_cells<T>(w[2][k] * row_mass, n[0], n[1], n[2]);
      }
      T* const to = corner + i * steps.x + j * steps.y;
      add_to(to, node[0] + (shifted_up<4>(node[1], all) + shifted_up<(kSize < 8 ? 4 : 8)>(node[2], all)));
      add_to(to + kSize, pushed_out<4, Pair>(node[1], pair) + pushed_out<8, Pair>(node[2], pair));
    }
  }
}

}  // namespace physmas::mpm

#endif
