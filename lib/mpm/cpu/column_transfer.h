// Transfers of a register of particles that fill a column of cells: neighbours along z, four particles each, so that
// lane 4 z + s is particle s of cell z. What a node of the stencil holds then lies in a NodeRow, in the right
// lanes but for one shuffle. All weights of a column's particles belong to the same 3 × 3 NodeRows.
#ifndef PHYSMAS_MPM_CPU_COLUMN_TRANSFER_H
#define PHYSMAS_MPM_CPU_COLUMN_TRANSFER_H

#include "mpm/cpu/grid_numbers.h"
#include "mpm/cpu/node_row_transfer.h"

namespace physmas::mpm {

// Particles per cell of a column, and cells per column (0: registers are too short for columns).
constexpr int kColumnSlots = 4;
template <class T>
constexpr int kColumnCells = kLanes<T> / kColumnSlots;
// Registers of one column that are carried together, at most.
constexpr int kColumnBatch = 4;

namespace column_detail {

template <class T>
using Part = typename NodeRow<T>::Part;

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
  constexpr auto all = std::make_index_sequence<NodeRow<T>::kPart>();
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

// A component of the velocity and its first moments about the particles, of R registers of the same column.
template <int R, class T>
PHYSMAS_INLINE void gather_component(int axis, const T* corner, const NodeSteps& steps, const Part<T> (*w)[3][3],
                                     const Part<T> (*to_center)[3], GridNumbers<T>* out) {
  using P = Part<T>;
  constexpr auto all = std::make_index_sequence<NodeRow<T>::kPart>();
  P total[R], first[R], along_x[R], along_y[R], along_z[R];
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    P sum[R], low[R], slope[R], z[R];
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const T* nodes = corner + i * steps.x + j * steps.y + axis;
      const P n0 = spread<1>(load(nodes), all), n1 = spread<1>(load(nodes + 4), all),
              n2 = spread<1>(load(nodes + 8), all);
#pragma GCC unroll 2
      for (int r = 0; r < R; ++r) {
        const P a = rounded_part(w[r][2][0] * n0);
        const P s = w[r][2][2] * n2 + (w[r][2][1] * n1 + a), d = w[r][2][2] * n2 - a;
        if (j == 0) {
          low[r] = rounded_part(w[r][1][0] * s);
          sum[r] = low[r], z[r] = w[r][1][0] * d;
        } else {
          if (j == 2) slope[r] = w[r][1][2] * s - low[r];
          sum[r] = w[r][1][j] * s + sum[r], z[r] = w[r][1][j] * d + z[r];
        }
      }
    }
#pragma GCC unroll 2
    for (int r = 0; r < R; ++r) {
      if (i == 0) {
        first[r] = rounded_part(w[r][0][0] * sum[r]);
        total[r] = first[r], along_y[r] = w[r][0][0] * slope[r], along_z[r] = w[r][0][0] * z[r];
      } else {
        if (i == 2) along_x[r] = w[r][0][2] * sum[r] - first[r];
        total[r] = w[r][0][i] * sum[r] + total[r], along_y[r] = w[r][0][i] * slope[r] + along_y[r],
        along_z[r] = w[r][0][i] * z[r] + along_z[r];
      }
    }
  }
  for (int r = 0; r < R; ++r) {
    const auto store = [&](int k, const P& lanes) { std::memcpy(out[r].number[k], &lanes, sizeof(lanes)); };
    store(out->vector(axis), total[r]);
    store(out->matrix(axis, 0), along_x[r] + to_center[r][0] * total[r]);
    store(out->matrix(axis, 1), along_y[r] + to_center[r][1] * total[r]);
    store(out->matrix(axis, 2), along_z[r] + to_center[r][2] * total[r]);
  }
}

}  // namespace column_detail

// R registers of one column. corner: the node at the base of the column's lowest cell.
template <int R, class T>
PHYSMAS_INLINE void gather_columns(const T* corner, const NodeSteps& steps, const Place<Lanes<T>>* at,
                                   GridNumbers<T>* out) {
  using P = column_detail::Part<T>;
  P w[R][3][3], to_center[R][3];
  for (int r = 0; r < R; ++r) {
    for (int a = 0; a < 3; ++a) {
      to_center[r][a] = same_bytes<P>(at[r].to_center[a]);
      for (int b = 0; b < 3; ++b) w[r][a][b] = same_bytes<P>(at[r].weight[a][b]);
    }
  }
  // Not unrolled: the kernels together have to fit into the cache of instructions.
#pragma GCC unroll 1
  for (int axis = 0; axis < 3; ++axis) column_detail::gather_component<R>(axis, corner, steps, w, to_center, out);
}

// Adds w {m, P + Q (node − centre node)} of all lanes of `count` registers of one column to the grid. What they bring
// to a NodeRow is summed in registers first.
template <class T>
PHYSMAS_INLINE void scatter_columns(T* corner, const NodeSteps& steps, int count, const GridNumbers<T>* in) {
  using namespace column_detail;
  using P = Part<T>;
  constexpr int kSize = NodeRow<T>::kPart;
  typedef T Pair __attribute__((vector_size(8 * sizeof(T))));
  constexpr auto all = std::make_index_sequence<kSize>();
  constexpr auto pair = std::make_index_sequence<8>();
  // Of one plane of nodes, for every register.
  struct Plane {
    P mass, momentum[3], step_y[3], step_z[3];
  } planes[kColumnBatch];
  // Not unrolled: the kernels together have to fit into the cache of instructions.
#pragma GCC unroll 1
  for (int i = 0; i < 3; ++i) {
    const T side = T(i - 1);
    for (int r = 0; r < count; ++r) {
      const auto number = [&](int k) { return load(in[r].number[k]); };
      const P w = load(in[r].weight[i]);
      planes[r].mass = w * number(in->kMass);
#pragma GCC unroll 3
      for (int a = 0; a < 3; ++a) {
        const P p = number(in->vector(a)), q = number(in->matrix(a, 0));
        planes[r].momentum[a] = w * (p + side * q);
        planes[r].step_y[a] = w * number(in->matrix(a, 1));
        planes[r].step_z[a] = w * number(in->matrix(a, 2));
      }
    }
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      P n[3][4] = {};
      for (int r = 0; r < count; ++r) {
        const Plane& plane = planes[r];
        const P w = load(in[r].weight[3 + j]);
        const P low = load(in[r].weight[6]), mid = load(in[r].weight[7]), high = load(in[r].weight[8]);
        const P mass = rounded_part(w * plane.mass);
        n[0][0] += low * mass, n[1][0] += mid * mass, n[2][0] += high * mass;
#pragma GCC unroll 3
        for (int a = 0; a < 3; ++a) {
          const P& p = plane.momentum[a];
          const P line = rounded_part(w * (j == 0 ? p - plane.step_y[a] : j == 1 ? p : p + plane.step_y[a]));
          const P step = rounded_part(w * plane.step_z[a]);
          n[0][1 + a] += low * rounded_part(line - step);
          n[1][1 + a] += mid * line;
          n[2][1 + a] += high * rounded_part(line + step);
        }
      }
      P node[3];
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) node[k] = sums_of_cells<T>(n[k][0], n[k][1], n[k][2], n[k][3]);
      T* const to = corner + i * steps.x + j * steps.y;
      add_to(to, node[0] + (shifted_up<4>(node[1], all) + shifted_up<(kSize < 8 ? 4 : 8)>(node[2], all)));
      add_to(to + kSize, pushed_out<4, Pair>(node[1], pair) + pushed_out<8, Pair>(node[2], pair));
    }
  }
}

}  // namespace physmas::mpm

#endif
