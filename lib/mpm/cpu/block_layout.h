// The order of a block's particles in registers of W slots: loose ones first, then columns (column_transfer.h).
#ifndef PHYSMAS_MPM_CPU_BLOCK_LAYOUT_H
#define PHYSMAS_MPM_CPU_BLOCK_LAYOUT_H

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "mpm/body_contact.h"
#include "mpm/cpu/blocks.h"
#include "mpm/cpu/column_transfer.h"

namespace physmas::mpm {

// A particle on its way to its new block: the old slot (when a state is loaded: the particle), its row, its cell there,
// and the old block's place relative to the new one, 0..26.
struct Arrival {
  static constexpr int kStay = 13;
  int source, row;
  std::uint8_t cell, shift;
};

// What the slots of a block will hold.
template <int W>
class BlockLayout {
 public:
  // A register becomes a column from so many particles on: each empty lane costs its share of the stress.
  static constexpr int kLeastFilled = W - W / 4;
  // Room for what leaves columns between sorts: a slot for so many particles in columns.
  static constexpr int kColumnsPerSpare = 8;

  std::vector<int> from;    // per slot: index of an arrival, -1: nothing
  std::vector<int> column;  // per register: the column's lowest cell, -1: not a column

  // Lays out arrivals[0 .. block.count - 1]; fills in the block's slots, loose registers, bodies and reach.
  void lay_out(const Arrival* arrivals, const BodyContact& contact, ParticleBlock& block);

 private:
  void take_columns(const Arrival* arrivals, bool mixed);
  void part_bodies(const Arrival* arrivals, const BodyContact& contact);

  std::vector<int> order_, in_columns_, loose_;  // kept for their memory
};

template <int W>
void BlockLayout<W>::lay_out(const Arrival* arrivals, const BodyContact& contact, ParticleBlock& block) {
  int next[kBlockNodes + 1] = {};
  bool mixed = false;
  for (int k = 0; k < block.count; ++k) {
    ++next[arrivals[k].cell + 1];
    mixed = mixed || arrivals[k].row != arrivals[0].row;
  }
  int low[3] = {kBlock, kBlock, kBlock}, high[3] = {};  // of the base nodes
  for (int cell = 0; cell < kBlockNodes; ++cell) {
    if (next[cell + 1] == 0) continue;
    const int base[3] = {cell / (kBlock * kBlock), cell / kBlock % kBlock, cell % kBlock};
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], base[axis]);
      high[axis] = std::max(high[axis], base[axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    // Two further nodes of the stencil; a cell of drift either way.
    block.low[axis] = static_cast<std::int8_t>(low[axis] - 1);
    block.high[axis] = static_cast<std::int8_t>(high[axis] + 3);
  }
  for (int c = 0; c < kBlockNodes; ++c) next[c + 1] += next[c];
  order_.resize(block.count);
  for (int k = 0; k < block.count; ++k) order_[next[arrivals[k].cell]++] = k;
  block.bodies = 0;
  if (mixed) {
    const auto rank = [&](int k) { return std::pair(contact.of(arrivals[k].row), arrivals[k].row); };
    std::stable_sort(order_.begin(), order_.end(), [&](int k, int l) { return rank(k) < rank(l); });
    for (int k = 0; k < block.count; ++k) block.bodies |= 1u << contact.of(arrivals[k].row);
  } else if (block.count > 0) {
    block.bodies = 1u << contact.of(arrivals[0].row);
  }
  take_columns(arrivals, mixed);
  if ((block.bodies & (block.bodies - 1)) != 0) part_bodies(arrivals, contact);

  const int room = static_cast<int>(loose_.size() + in_columns_.size() / kColumnsPerSpare);
  block.loose = (room + W - 1) / W;
  block.strayed = 0;
  from.assign(block.loose * W, -1);
  std::copy(loose_.begin(), loose_.end(), from.begin());
  from.insert(from.end(), in_columns_.begin(), in_columns_.end());
  block.slots = static_cast<int>(from.size());
  column.insert(column.begin(), block.loose, -1);
}

// Fills registers of loose particles up where the next body's begin.
template <int W>
void BlockLayout<W>::part_bodies(const Arrival* arrivals, const BodyContact& contact) {
  const std::vector<int> together = std::move(loose_);
  loose_.clear();
  int body = -1;
  for (const int k : together) {
    const int next = contact.of(arrivals[k].row);
    if (next != body) loose_.resize((loose_.size() + W - 1) / W * W, -1);
    body = next;
    loose_.push_back(k);
  }
}

// From order_, sorted by row and cell, to columns, in_columns_ and loose_.
template <int W>
void BlockLayout<W>::take_columns(const Arrival* arrivals, bool mixed) {
  constexpr int kCells = W / kColumnSlots;
  column.clear();
  in_columns_.clear();
  if constexpr (kCells < 2) {
    loose_ = order_;
    return;
  } else {
    loose_.clear();
    const int end = static_cast<int>(order_.size());
    for (int at = 0; at < end;) {
      // The particles of one row in the cells of one column.
      const int here = arrivals[order_[at]].cell / kCells, row = arrivals[order_[at]].row;
      int begin[kCells], count[kCells] = {};
      for (; at < end; ++at) {
        const Arrival& arrival = arrivals[order_[at]];
        if (arrival.cell / kCells != here || (mixed && arrival.row != row)) break;
        if (count[arrival.cell % kCells]++ == 0) begin[arrival.cell % kCells] = at;
      }
      while (true) {
        int filled = 0;
        for (const int c : count) filled += std::min(c, kColumnSlots);
        if (filled < kLeastFilled) break;
        for (int z = 0; z < kCells; ++z) {
          const int taken = std::min(count[z], kColumnSlots);
          for (int s = 0; s < kColumnSlots; ++s) in_columns_.push_back(s < taken ? order_[begin[z]++] : -1);
          count[z] -= taken;
        }
        column.push_back(here * kCells);
      }
      for (int z = 0; z < kCells; ++z) {
        for (; count[z] > 0; --count[z]) loose_.push_back(order_[begin[z]++]);
      }
    }
  }
}

}  // namespace physmas::mpm

#endif
