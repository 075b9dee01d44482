// Carries one register of particles after the other to the grid and back: particles that are where their column
// (column_transfer.h) was sorted to all at once, others one by one (row_transfer.h).
#ifndef PHYSMAS_MPM_GRID_EXCHANGE_H
#define PHYSMAS_MPM_GRID_EXCHANGE_H

#include "mpm/column_transfer.h"
#include "mpm/grid_layout.h"
#include "mpm/row_transfer.h"

namespace physmas::mpm {

// Bit l: lane l.
using LaneBits = unsigned;

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
class GridExchange {
 public:
  using V = Lanes<T>;
  static constexpr int W = kLanes<T>;

  explicit GridExchange(const GridLayout& grid) : step_{grid.step_x(), grid.step_y()} {
    for (auto& s : sum_) s = Row<T>::zero();
    std::memset(record_, 0, sizeof(record_));
  }

  // lanes: those that hold particles. nodes: from the block's first on. column: cell of the block that lanes 0..3 were
  // sorted to, or -1 when the register is no column. Other lanes get numbers without meaning.
  __attribute__((noinline)) void gather(const T* nodes, const Place<V>& at, int column, LaneBits lanes,
                                        Vec3<V>& velocity, Mat3<V>& moment) {
    Mask strayed(true);
    if constexpr (kColumnCells<T> >= 2) {
      if (column >= 0) {
        strayed = strayed_from(at, column);
        const LaneBits bits = lane_bits(strayed) & lanes;
        if (in_column(bits)) {
          gather_column(nodes + offset_of(column), step_, at, velocity, moment);
          if (bits == 0) return;
          lanes = bits;
        } else {
          strayed = Mask(true);
        }
      }
    }
    place(at);
    const RowSteps step = step_;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int l = __builtin_ctz(lanes);
      T w[9];
      for (int k = 0; k < 9; ++k) w[k] = weight_[k][l];
      gather_particle(nodes + offset_[l], step, w, w + 3, w + 6, record_[l]);
    }
    records_to_lanes<T>(record_, lanes_);
    for (int a = 0; a < 3; ++a) {
      velocity[a] = select(strayed, V(lanes_[1 + a], stdx::vector_aligned), velocity[a]);
      for (int b = 0; b < 3; ++b) {
        moment[a][b] = select(strayed, V(lanes_[4 + 4 * b + 1 + a], stdx::vector_aligned), moment[a][b]);
      }
    }
  }

  // Adds w {m, P + Q (node − centre node)} to the grid, some of it not before `flush`. Lanes without a particle must
  // have no mass and no momentum.
  __attribute__((noinline)) void scatter(T* nodes, const Place<V>& at, int column, LaneBits lanes, const V& mass,
                                         const Vec3<V>& momentum, const Mat3<V>& Q) {
    if constexpr (kColumnCells<T> >= 2) {
      if (column >= 0) {
        const Mask strayed = strayed_from(at, column);
        const LaneBits bits = lane_bits(strayed) & lanes;
        strays_ += __builtin_popcount(bits);
        if (bits == 0) return scatter_column(nodes + offset_of(column), step_, at, mass, momentum, Q);
        if (in_column(bits)) {
          const V none(T(0));
          const Vec3<V> nothing = {none, none, none};
          scatter_column(nodes + offset_of(column), step_, at, select(strayed, none, mass),
                         select(strayed, nothing, momentum), select(strayed, Mat3<V>{{nothing, nothing, nothing}}, Q));
          lanes = bits;
        }
      }
    }
    place(at);
    mass.copy_to(lanes_[0], stdx::vector_aligned);
    for (int a = 0; a < 3; ++a) {
      momentum[a].copy_to(lanes_[1 + a], stdx::vector_aligned);
      for (int b = 0; b < 3; ++b) Q[a][b].copy_to(lanes_[4 + 4 * b + 1 + a], stdx::vector_aligned);
    }
    for (int k = 4; k < 16; k += 4) V(T(0)).copy_to(lanes_[k], stdx::vector_aligned);
    lanes_to_records<T>(lanes_, record_);
    // In registers, not in this object.
    Row<T> sum[9];
    for (int k = 0; k < 9; ++k) sum[k] = sum_[k];
    int corner = corner_;
    const RowSteps step = step_;
    for (; lanes != 0; lanes &= lanes - 1) {
      const int l = __builtin_ctz(lanes);
      if (offset_[l] != corner) {
        if (corner != kNowhere) flush_rows(sum, nodes + corner, step);
        corner = offset_[l];
      }
      T w[9];
      for (int k = 0; k < 9; ++k) w[k] = weight_[k][l];
      scatter_particle(sum, w, w + 3, w + 6, record_[l]);
    }
    for (int k = 0; k < 9; ++k) sum_[k] = sum[k];
    corner_ = corner;
  }

  // Particles so far that were scattered while not in their column's cell.
  int strays() const { return strays_; }

  void flush(T* nodes) {
    if (corner_ != kNowhere) flush_rows(sum_, nodes + corner_, step_);
    corner_ = kNowhere;
  }

 private:
  using Mask = typename V::mask_type;

  // Beyond half a register, one by one is faster than twice.
  static bool in_column(LaneBits strayed) { return __builtin_popcount(strayed) <= W / 2; }
  static Mask strayed_from(const Place<V>& at, int column) {
    const int x = column / (kBlock * kBlock), y = column / kBlock % kBlock, z = column % kBlock;
    const V z_of_lane([z](int l) { return T(z + l / kColumnSlots); });
    return at.base.x != V(T(x)) || at.base.y != V(T(y)) || at.base.z != z_of_lane;
  }
  void place(const Place<V>& at) {
    for (int k = 0; k < 9; ++k) at.weight[k / 3][k % 3].copy_to(weight_[k], stdx::vector_aligned);
    const auto whole = [](const V& x) {
      typedef T Numbers __attribute__((vector_size(sizeof(V))));
      return __builtin_convertvector(same_bytes<Numbers>(x), Integers);
    };
    const Integers offsets = whole(at.base.x) * static_cast<int>(step_.x) +
                             whole(at.base.y) * static_cast<int>(step_.y) + whole(at.base.z) * 4;
    std::memcpy(offset_, &offsets, sizeof(offsets));
  }
  std::ptrdiff_t offset_of(int cell) const {
    return std::ptrdiff_t{cell / (kBlock * kBlock)} * static_cast<int>(step_.x) +
           cell / kBlock % kBlock * static_cast<int>(step_.y) + cell % kBlock * 4;
  }

  typedef int Integers __attribute__((vector_size(W * sizeof(int))));
  static constexpr int kNowhere = std::numeric_limits<int>::min();

  const RowSteps step_;
  Row<T> sum_[9];  // of the particles that were scattered one by one to the stencil at corner_
  int corner_ = kNowhere, strays_ = 0;
  alignas(64) T record_[W][16];
  alignas(64) T weight_[9][W];  // three along x, y and z
  alignas(64) T lanes_[16][W];
  alignas(64) int offset_[W];  // of the stencils, from the block's first node
};

}  // namespace physmas::mpm

#endif
