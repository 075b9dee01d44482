// Carries registers of particles to the grid and back: columns (column_transfer.h) all at once, others particle by
// particle (node_row_transfer.h).
#ifndef PHYSMAS_MPM_CPU_GRID_EXCHANGE_H
#define PHYSMAS_MPM_CPU_GRID_EXCHANGE_H

#include "mpm/cpu/column_transfer.h"
#include "mpm/cpu/grid_layout.h"
#include "mpm/cpu/node_row_transfer.h"

namespace physmas::mpm {

template <class T>
class GridExchange {
 public:
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;

  explicit GridExchange(const GridLayout& grid) : step_{grid.step_x(), grid.step_y()} {}

  // Positions as below.
  static PHYSMAS_INLINE Vec3<V> load(const T* x) {
    return {V(x, stdx::vector_aligned), V(x + W, stdx::vector_aligned), V(x + 2 * W, stdx::vector_aligned)};
  }

  // nodes: velocities from the block's first node on. x: the particles' positions, W numbers an axis [cells from that
  // node]. lanes: those that hold particles; others get zeros.
  __attribute__((noinline)) void gather_particles(const T* nodes, const T* x, LaneBits lanes,
                                                  GridNumbers<T>& out) const {
    const Vec3<V> at = load(x);
    const Vec3<V> base = base_of(at);
    const Place<V> place = place_of(at, base);
    out.set_weights(place);
    alignas(64) int offset[W];
    write_offsets(base, offset);
    alignas(64) T record[W][16];
    const NodeSteps step = step_;
    if (lanes != kAllLanes<T>) std::memset(record, 0, sizeof(record));
    for (; lanes != 0; lanes &= lanes - 1) {
      const int l = __builtin_ctz(lanes);
      T w[9];
      for (int k = 0; k < 9; ++k) w[k] = out.weight[k][l];
      gather_particle(nodes + offset[l], step, w, w + 3, w + 6, record[l]);
    }
    records_to_lanes<T>(record, out.number);
    for (int a = 0; a < 3; ++a) {
      const V v = out.get(out.vector(a));
      for (int b = 0; b < 3; ++b) out.set(out.matrix(a, b), out.get(out.matrix(a, b)) + place.to_center[b] * v);
    }
  }

  // nodes: what they have received, from the block's first on. in: with weights that belong to x.
  __attribute__((noinline)) void scatter_particles(T* nodes, const T* x, LaneBits lanes, GridNumbers<T>& in) const {
    const Vec3<V> base = base_of(load(x));
    const V start = node_row_start(base.z);
    const LaneBits later = lane_bits(base.z > start);
    alignas(64) int offset[W];
    write_offsets({base.x, base.y, start}, offset);
    for (int k = 4; k < 16; k += 4) in.set(k, V(T(0)));
    alignas(64) T record[W][16];
    lanes_to_records<T>(in.number, record);
    alignas(64) T wxy[9][W];
    for (int k = 0; k < 9; ++k) {
      (V(in.weight[k / 3], stdx::vector_aligned) * V(in.weight[3 + k % 3], stdx::vector_aligned))
          .copy_to(wxy[k], stdx::vector_aligned);
    }
    const NodeSteps step = step_;
    NodeRow<T> sum[9];
    const auto clear = [&] {
      for (NodeRow<T>& s : sum) s = NodeRow<T>::zero();
    };
    clear();
    int corner = offset[lanes != 0 ? __builtin_ctz(lanes) : 0];
    for (; lanes != 0; lanes &= lanes - 1) {
      const int l = __builtin_ctz(lanes);
      if (offset[l] != corner) {
        add_node_rows(sum, nodes + corner, step);
        clear();
        corner = offset[l];
      }
      scatter_particle(sum, later >> l & 1, wxy[0] + l, in.weight[6] + l, record[l]);
    }
    add_node_rows(sum, nodes + corner, step);
  }

  // The base node of a column's lanes. column: the block's cell that is the column's lowest.
  static PHYSMAS_INLINE Vec3<V> column_base(int column) {
    const V z_of_lane([](int l) { return T(l / kColumnSlots); });
    return {V(T(column / (kBlock * kBlock))), V(T(column / kBlock % kBlock)), V(T(column % kBlock)) + z_of_lane};
  }
  // `count` registers of one column, at most kColumnBatch. x and lanes: per register.
  __attribute__((noinline)) void gather_columns(const T* nodes, int column, int count, const T* const* x,
                                                const LaneBits* lanes, GridNumbers<T>* out) const {
    const Vec3<V> base = column_base(column);
    const auto some = [&](int r, auto how_many) PHYSMAS_LAMBDA_INLINE {
      constexpr int R = decltype(how_many)::value;
      Place<V> place[R];
      for (int k = 0; k < R; ++k) {
        place[k] = place_of(load(x[r + k]), base);
        if (lanes[r + k] == kAllLanes<T>) continue;
        const auto held = lane_mask<T>(lanes[r + k]);
        for (V& w : place[k].weight[0]) w = select(held, w, V(T(0)));
      }
      // Where registers are too short for columns there are none.
      if constexpr (kColumnCells<T> >= 2) mpm::gather_columns<R>(nodes + offset_of(column), step_, place, out + r);
    };
    int r = 0;
    for (; r + 2 <= count; r += 2) some(r, std::integral_constant<int, 2>());
    if (r < count) some(r, std::integral_constant<int, 1>());
  }
  // Lanes without a particle must have no mass and no momentum.
  __attribute__((noinline)) void scatter_columns(T* nodes, int column, int count, const GridNumbers<T>* in) const {
    if constexpr (kColumnCells<T> >= 2) mpm::scatter_columns(nodes + offset_of(column), step_, count, in);
  }

 private:
  // Of the stencils, from the block's first node.
  PHYSMAS_INLINE void write_offsets(const Vec3<V>& base, int* offset) const {
    typedef int Integers __attribute__((vector_size(W * sizeof(int))));
    const auto whole = [](const V& x) {
      typedef T Numbers __attribute__((vector_size(sizeof(V))));
      return __builtin_convertvector(same_bytes<Numbers>(x), Integers);
    };
    const Integers offsets =
        whole(base.x) * static_cast<int>(step_.x) + whole(base.y) * static_cast<int>(step_.y) + whole(base.z) * 4;
    std::memcpy(offset, &offsets, sizeof(offsets));
  }
  std::ptrdiff_t offset_of(int cell) const {
    return cell / (kBlock * kBlock) * step_.x + cell / kBlock % kBlock * step_.y + cell % kBlock * 4;
  }

  const NodeSteps step_;
};

}  // namespace physmas::mpm

#endif
