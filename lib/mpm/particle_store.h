// The particles of a run in the order and precision that the substep works with.
//
// Slots are sorted by block, in a block by row, so that nearly all lanes of a register share a branch, and then by
// cell, so that neighbours share nodes. Every block begins with a new register. Positions are in cells from the block's
// first node, which makes float positions eight to sixteen times finer than absolute ones.
#ifndef PHYSMAS_MPM_PARTICLE_STORE_H
#define PHYSMAS_MPM_PARTICLE_STORE_H

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mpm/blocks.h"
#include "mpm/buffer.h"
#include "mpm/lanes.h"
#include "mpm/stepper.h"

namespace physmas::mpm {

template <class T>
class ParticleStore {
 public:
  static constexpr int W = kLanes<T>;

  // Particles stay `safe_cells` away from the edge of the grid. setup outlives the store.
  ParticleStore(const StepperSetup& setup, double safe_cells);

  // Takes over a state, in a new order; returns how many positions had to be put on the edge of the safe interior.
  long long load(const State& state);
  void store(State& state) const;
  // Puts every particle into the block that it is in now. Velocities and affine states are lost.
  void sort();

  BlockMap map;
  // One number per slot; those of a register of slots are contiguous.
  struct Channel {
    T* first = nullptr;
    size_t step = 0;  // from register to register
    T& operator[](size_t slot) const { return first[slot / W * step + slot % W]; }
  };
  // Empty slots hold a particle at rest of no volume.
  Channel x[3], F[9], volume;                  // [cells], row-major, rest volume [m^3]
  Channel strength;                            // [Pa], when some row is plasticine
  Channel total_F[9];                          // row-major, when tracked
  Buffer<int> particle;                        // the callers' index, -1: empty slot
  Channel v[3], C[9];                          // m/s, 1/s; valid after load and after the last pass of an interval
  std::vector<int> group_row;                  // row of all lanes of a group of W slots, -1 when mixed
  std::vector<std::uint8_t> group_controlled;  // whether any lane of the group is in a control group
  bool has_strength = false;

  int slots() const { return slots_; }
  // Brings the numbers of a register of slots into the cache.
  PHYSMAS_INLINE void prefetch(int group) const {
    const T* at = x[0].first + group * x[0].step;
    for (int c = 0; c < channels_; ++c) __builtin_prefetch(at + c * W, 1);
  }
  size_t bytes() const;

 private:
  // A particle on its way to its new block: the old slot (load: the particle), its cell there, and the old block's
  // place relative to the new one, 0..26.
  struct Arrival {
    int source;
    std::uint8_t cell, shift;
  };
  static constexpr int kStay = 13;

  int row_of(int i) const { return setup_.row[i]; }
  void place(bool from_slots);
  void bind();
  void describe_groups(const ParticleBlock& block);
  // Calls function(channel, what an empty slot holds).
  template <class Function>
  void for_each_channel(const Function& function) {
    for (auto& c : x) function(c, T(2));
    for (int k = 0; k < 9; ++k) function(F[k], T(k % 4 == 0));
    function(volume, T(0));
    if (has_strength) function(strength, T(1));
    for (int k = 0; setup_.track_total_F && k < 9; ++k) function(total_F[k], T(k % 4 == 0));
  }

  const StepperSetup& setup_;
  double dx_, safe_cells_;
  int slots_ = 0;
  std::vector<Arrival> arrivals_;  // in the order of the blocks
  std::vector<int> from_;          // per slot: index into arrivals_, -1 for an empty one
  int channels_ = 0;
  // What lives from substep to substep; and where sorting puts it, which between intervals keeps v and C instead.
  Buffer<T> numbers_, other_;
  Buffer<int> spare_particle_;
};

template <class T>
ParticleStore<T>::ParticleStore(const StepperSetup& setup, double safe_cells)
    : map(setup.domain.n + 1), setup_(setup), dx_(setup.domain.dx()), safe_cells_(safe_cells) {
  for (const int row : setup.row) has_strength = has_strength || setup.branches[row] == Branch::plasticine;
  for_each_channel([&](Channel&, T) { ++channels_; });
}

namespace store_detail {

constexpr int cell_index(const int* base) {
  return (base[0] * kBlock + base[1]) * kBlock + base[2];
}

}  // namespace store_detail

template <class T>
long long ParticleStore<T>::load(const State& state) {
  const int count = static_cast<int>(state.size());
  const double low = safe_cells_, high = setup_.domain.n - safe_cells_;
  const auto cells_at = [&](int i, int axis) { return at_most(at_least(state.x[i][axis] / dx_, low), high); };
  std::vector<int> id(count);
  std::vector<std::uint8_t> cell(count);
  long long clamped = 0;
  for (int i = 0; i < count; ++i) {
    bool moved = false;
    int block[3], inside[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double cells = cells_at(i, axis);
      moved = moved || cells != state.x[i][axis] / dx_;
      const int base = static_cast<int>(std::floor(cells - 0.5));
      block[axis] = base / kBlock, inside[axis] = base % kBlock;
    }
    clamped += moved;
    id[i] = map.block_id(block[0], block[1], block[2]);
    cell[i] = static_cast<std::uint8_t>(store_detail::cell_index(inside));
  }
  map.start(id);
  for (const int i : id) ++map.particle_blocks[map.index_of(i)].count;
  std::vector<int> next;
  int first = 0;
  for (ParticleBlock& block : map.particle_blocks) {
    next.push_back(block.first = first);
    first += block.count;
  }
  arrivals_.resize(count);
  for (int i = 0; i < count; ++i) arrivals_[next[map.index_of(id[i])]++] = {i, cell[i], kStay};
  place(false);

  numbers_.resize(static_cast<size_t>(slots_) * channels_);
  other_.resize(static_cast<size_t>(slots_) * channels_);
  bind();
  particle.resize(slots_);
  setup_.team->for_each(static_cast<int>(map.particle_blocks.size()), [&](int b) {
    const ParticleBlock& block = map.particle_blocks[b];
    for (int s = block.begin; s < block.begin + block.slots; ++s) {
      const int i = from_[s] >= 0 ? arrivals_[from_[s]].source : -1;
      const bool real = i >= 0;
      particle[s] = i;
      volume[s] = real ? T(setup_.volume[i]) : T(0);
      if (has_strength) strength[s] = real ? T(state.strength[i]) : T(1);
      for (int a = 0; a < 3; ++a) {
        x[a][s] = real ? T(cells_at(i, a) - kBlock * block.position[a]) : T(2);
        v[a][s] = real ? T(state.v[i][a]) : T(0);
      }
      for (int k = 0; k < 9; ++k) {
        F[k][s] = real ? T(state.F[i][k / 3][k % 3]) : T(k % 4 == 0);
        C[k][s] = real ? T(state.C[i][k / 3][k % 3]) : T(0);
        if (setup_.track_total_F) total_F[k][s] = real ? T(state.total_F[i][k / 3][k % 3]) : T(k % 4 == 0);
      }
    }
    describe_groups(block);
  });
  return clamped;
}

template <class T>
void ParticleStore<T>::store(State& state) const {
  setup_.team->for_each(static_cast<int>(map.particle_blocks.size()), [&](int b) {
    const ParticleBlock& block = map.particle_blocks[b];
    for (int s = block.begin; s < block.begin + block.slots; ++s) {
      const int i = particle[s];
      if (i < 0) continue;
      for (int a = 0; a < 3; ++a) {
        state.x[i][a] = (double(x[a][s]) + kBlock * block.position[a]) * dx_;
        state.v[i][a] = v[a][s];
      }
      for (int k = 0; k < 9; ++k) {
        state.F[i][k / 3][k % 3] = F[k][s];
        state.C[i][k / 3][k % 3] = C[k][s];
        if (setup_.track_total_F) state.total_F[i][k / 3][k % 3] = total_F[k][s];
      }
      if (has_strength) state.strength[i] = strength[s];
    }
  });
}

// From arrivals_ and the blocks' counts: the order inside the blocks, slots, and where each slot's particle comes from.
template <class T>
void ParticleStore<T>::place(bool from_slots) {
  slots_ = 0;
  for (ParticleBlock& block : map.particle_blocks) {
    block.begin = slots_;
    block.slots = (block.count + W - 1) / W * W;
    slots_ += block.slots;
  }
  from_.assign(slots_, -1);
  group_row.assign(slots_ / W, -1);
  group_controlled.assign(slots_ / W, 0);
  setup_.team->for_each(static_cast<int>(map.particle_blocks.size()), [&](int b) {
    ParticleBlock& block = map.particle_blocks[b];
    int low[3] = {kBlock, kBlock, kBlock}, high[3] = {};  // of the base nodes
    int next[kBlockNodes + 1] = {};
    bool mixed = false;
    const auto arrival_row = [&](int k) {
      return row_of(from_slots ? particle[arrivals_[k].source] : arrivals_[k].source);
    };
    const int row = arrival_row(block.first);
    for (int k = block.first; k < block.first + block.count; ++k) {
      const int cell = arrivals_[k].cell;
      ++next[cell + 1];
      mixed = mixed || arrival_row(k) != row;
      const int base[3] = {cell / (kBlock * kBlock), cell / kBlock % kBlock, cell % kBlock};
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], base[axis]);
        high[axis] = std::max(high[axis], base[axis]);
      }
    }
    for (int c = 0; c < kBlockNodes; ++c) next[c + 1] += next[c];
    int* const from = from_.data() + block.begin;
    for (int k = block.first; k < block.first + block.count; ++k) from[next[arrivals_[k].cell]++] = k;
    if (mixed) {
      std::stable_sort(from, from + block.count, [&](int k, int l) { return arrival_row(k) < arrival_row(l); });
    }
    for (int axis = 0; axis < 3; ++axis) {
      // Arena node of the base is base + 1; two further nodes of the stencil; a cell of drift either way.
      block.now_low[axis] = static_cast<std::int8_t>(low[axis] + 1);
      block.now_high[axis] = static_cast<std::int8_t>(high[axis] + 3);
      block.low[axis] = static_cast<std::int8_t>(low[axis]);
      block.high[axis] = static_cast<std::int8_t>(high[axis] + 4);
    }
  });
  map.connect();
}

template <class T>
void ParticleStore<T>::describe_groups(const ParticleBlock& block) {
  for (int g = block.begin / W; g < (block.begin + block.slots) / W; ++g) {
    int row = row_of(particle[g * W]);
    for (int l = 0; l < W; ++l) {
      const int i = particle[g * W + l];
      if (i < 0) continue;
      if (row_of(i) != row) row = -1;
      group_controlled[g] |= setup_.control_group[i] != 0;
    }
    group_row[g] = row;
  }
}

template <class T>
void ParticleStore<T>::sort() {
  const std::vector<ParticleBlock> old = map.particle_blocks;
  const int blocks = static_cast<int>(old.size());
  // Particles drift by less than a cell between sorts, so each goes to one of 27 blocks.
  struct Step {
    std::uint8_t cell, code;
  };
  std::vector<Step> step(slots_);
  std::vector<std::array<int, 27>> leaving(blocks);
  setup_.team->for_each(blocks, [&](int b) {
    leaving[b] = {};
    for (int s = old[b].begin; s < old[b].begin + old[b].slots; ++s) {
      if (particle[s] < 0) continue;
      int inside[3], code = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const T base = at_most(at_least(std::floor(x[axis][s] - T(0.5)), T(-1)), T(kBlock));
        const int node = static_cast<int>(base) + kBlock;
        inside[axis] = node % kBlock;
        code = 3 * code + node / kBlock;
      }
      step[s] = {static_cast<std::uint8_t>(store_detail::cell_index(inside)), static_cast<std::uint8_t>(code)};
      ++leaving[b][code];
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
  setup_.team->for_each(blocks, [&](int b) {
    for (int s = old[b].begin; s < old[b].begin + old[b].slots; ++s) {
      if (particle[s] >= 0) arrivals_[leaving[b][step[s].code]++] = {s, step[s].cell, step[s].code};
    }
  });
  place(true);

  spare_particle_.resize(slots_);
  other_.resize(static_cast<size_t>(slots_) * channels_);
  const int now = static_cast<int>(map.particle_blocks.size());
  setup_.team->for_each(now, [&](int b) {
    const ParticleBlock& block = map.particle_blocks[b];
    for (int s = block.begin; s < block.begin + block.slots; ++s) {
      spare_particle_[s] = from_[s] >= 0 ? particle[arrivals_[from_[s]].source] : -1;
    }
  });
  particle.swap(spare_particle_);
  setup_.team->for_each(now, [&](int b) {
    const ParticleBlock& block = map.particle_blocks[b];
    T* to = other_.data() + static_cast<size_t>(block.begin) * channels_;
    for (int group = block.begin; group < block.begin + block.slots; group += W) {
      for_each_channel([&](const Channel& c, T empty) {
        for (int s = group; s < group + W; ++s) *to++ = from_[s] >= 0 ? c[arrivals_[from_[s]].source] : empty;
      });
    }
  });
  numbers_.swap(other_);
  other_.resize(static_cast<size_t>(slots_) * channels_);
  bind();
  setup_.team->for_each(now, [&](int b) {
    const ParticleBlock& block = map.particle_blocks[b];
    for (int s = block.begin; s < block.begin + block.slots; ++s) {
      if (from_[s] < 0) continue;
      // From the old block's origin to the new one's: a whole number of cells.
      const int code = arrivals_[from_[s]].shift;
      const int moved[3] = {code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1};
      for (int axis = 0; axis < 3; ++axis) x[axis][s] -= T(kBlock * moved[axis]);
    }
    describe_groups(block);
  });
}

// Channels lie one after the other in each register's numbers.
template <class T>
void ParticleStore<T>::bind() {
  const size_t step = static_cast<size_t>(channels_) * W;
  int next = 0;
  for_each_channel([&](Channel& c, T) { c = {numbers_.data() + W * next++, step}; });
  next = 0;
  for (auto& c : v) c = {other_.data() + W * next++, step};
  for (auto& c : C) c = {other_.data() + W * next++, step};
}

template <class T>
size_t ParticleStore<T>::bytes() const {
  return 2 * static_cast<size_t>(slots_) * channels_ * sizeof(T) + (2 + 1) * slots_ * sizeof(int) +
         arrivals_.size() * sizeof(Arrival);
}

}  // namespace physmas::mpm

#endif
