// Puts the particles of a store in order again. Part of particle_store.h.
#ifndef PHYSMAS_MPM_CPU_PARTICLE_SORT_H
#define PHYSMAS_MPM_CPU_PARTICLE_SORT_H

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "mpm/cpu/particle_store.h"

namespace physmas::mpm {

template <class T>
void ParticleStore<T>::sort() {
  const std::vector<ParticleBlock> old = map.particle_blocks;
  const int blocks = static_cast<int>(old.size());
  // Particles drift by less than a cell between sorts, so each goes to one of 27 blocks.
  departures_.resize(slots_);
  std::vector<std::array<int, 27>> leaving(blocks);
  team_.for_each(blocks, [&](int b) {
    leaving[b] = {};
    for (int reg = old[b].begin / W; reg < (old[b].begin + old[b].slots) / W; ++reg) {
      using V = Lanes<T>;
      V cell(T(0)), code(T(0));
      for (int axis = 0; axis < 3; ++axis) {
        const V x_here(numbers(reg) + axis * W, stdx::vector_aligned);
        const V base = at_most(at_least(round_down(x_here - T(0.5)), V(T(-1))), V(T(kBlock)));
        const V block = select(base < V(T(0)), V(T(0)), select(base < V(T(kBlock)), V(T(1)), V(T(2))));
        cell = cell * T(kBlock) + (base - T(kBlock) * (block - T(1)));
        code = code * T(3) + block;
      }
      alignas(64) T cells[W], codes[W];
      cell.copy_to(cells, stdx::vector_aligned);
      code.copy_to(codes, stdx::vector_aligned);
      for (int l = 0; l < W; ++l) {
        departures_[reg * W + l] = {static_cast<std::uint8_t>(cells[l]), static_cast<std::uint8_t>(codes[l])};
        leaving[b][static_cast<int>(codes[l])] += registers[reg].lanes >> l & 1;
      }
    }
  });
  const auto target = [&](int b, int code) {
    return old[b].id + (code / 9 - 1) * map.id_stride(0) + (code / 3 % 3 - 1) * map.id_stride(1) + code % 3 - 1;
  };
  std::vector<int> ids;
  for (int b = 0; b < blocks; ++b) {
    for (int code = 0; code < 27; ++code) {
      if (leaving[b][code] > 0) ids.push_back(target(b, code));
    }
  }
  map.start(std::move(ids));
  for (int b = 0; b < blocks; ++b) {
    for (int code = 0; code < 27; ++code) {
      if (leaving[b][code] > 0) {
        map.particle_blocks[map.index_of(target(b, code))].count += leaving[b][code];
      }
    }
  }
  int first = 0;
  std::vector<int> next;
  for (ParticleBlock& block : map.particle_blocks) {
    next.push_back(block.first = first);
    first += block.count;
  }
  for (int b = 0; b < blocks; ++b) {
    for (int code = 0; code < 27; ++code) {
      const int count = leaving[b][code];
      if (count == 0) continue;
      int& at = next[map.index_of(target(b, code))];
      leaving[b][code] = at;
      at += count;
    }
  }
  arrivals_.resize(setup_.row.size());
  team_.for_each(blocks, [&](int b) {
    for (int s = old[b].begin; s < old[b].begin + old[b].slots; ++s) {
      if (particle[s] < 0) continue;
      const Departure& d = departures_[s];
      const int common = registers[s / W].row;
      arrivals_[leaving[b][d.code]++] = {s, common >= 0 ? common : setup_.row[particle[s]], d.cell, d.code};
    }
  });
  place();

  spare_particle_.resize(slots_);
  other_.resize(static_cast<size_t>(slots_) * channels_);
  const int now = static_cast<int>(map.particle_blocks.size());
  const size_t step = static_cast<size_t>(channels_) * W;
  team_.for_each(now, [&](int b) {
    for_each_register(b, [&](int reg, const Arrival* const* from) {
      // What comes there was not far away before.
      prefetch(reg + kPrefetchSort);
      const T* numbers_of[W];
      for (int l = 0; l < W; ++l) {
        const unsigned slot = from[l] ? from[l]->source : 0;
        numbers_of[l] = from[l] ? numbers_.data() + slot / W * step + slot % W : empty_.data() + l;
        spare_particle_[reg * W + l] = from[l] ? particle[slot] : -1;
      }
      T* const to = other_.data() + reg * step;
      for (int c = 0; c < channels_; ++c) {
        for (int l = 0; l < W; ++l) to[c * W + l] = numbers_of[l][c * W];
      }
      for (int l = 0; l < W; ++l) {
        const int code = from[l] ? from[l]->shift : Arrival::kStay;
        if (from[l] && code == Arrival::kStay) continue;
        // From the old block's origin to the new one's: a whole number of cells.
        const int moved[3] = {code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1};
        for (int axis = 0; axis < 3; ++axis) {
          T& x_here = to[axis * W + l];
          x_here = from[l] ? x_here - T(kBlock * moved[axis]) : rest(reg * W + l, axis);
        }
      }
      describe(reg, from, &spare_particle_[reg * W]);
    });
  });
  particle.swap(spare_particle_);
  numbers_.swap(other_);
  other_.resize(static_cast<size_t>(slots_) * channels_);
  bind();
}

}  // namespace physmas::mpm

#endif
