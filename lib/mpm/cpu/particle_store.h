// The particles of a run in the order and precision that the substep works with.
//
// Slots are sorted by block. A block ends with registers that are columns: four particles of one row in each of some
// cells that are neighbours along z (column_transfer.h), where a cell has that many. What is left lies before them by
// body and row, so that nearly all lanes of a register share a branch, and then by cell; no register holds particles of
// two bodies. Between sorts a particle that leaves
// its cell of a column moves to a free lane of another column or of the loose registers. Every block begins with a new
// register. Positions are in cells from the block's first node, which makes float positions eight to sixteen times
// finer than absolute ones.
#ifndef PHYSMAS_MPM_CPU_PARTICLE_STORE_H
#define PHYSMAS_MPM_CPU_PARTICLE_STORE_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/team.h"
#include "mpm/cpu/block_layout.h"
#include "mpm/cpu/buffer.h"
#include "mpm/cpu/grid_exchange.h"
#include "mpm/state.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm {

template <class T>
class ParticleStore {
 public:
  static constexpr int W = kLanes<T>;

  // Particles stay `safe_cells` away from the edge of the grid. setup and team outlive the store.
  ParticleStore(const StepperSetup& setup, Team& team, double safe_cells);

  // Takes over a state, in a new order; returns how many positions had to be put on the edge of the safe interior.
  long long load(const State& state);
  void store(State& state) const;
  // Puts every particle into the block that it is in now. Velocities and affine states are lost.
  void sort();
  // Finds other places for the lanes of a block's columns that are `leaving`: in a column of the cell that they are in
  // now, or among the loose registers. Where the block has no room for them, the register no longer is a column.
  void leave_columns(int block);

  BlockMap map;
  // One number per slot; those of a register of slots are contiguous.
  struct Channel {
    T* first = nullptr;
    size_t step = 0;  // from register to register
    T& operator[](size_t slot) const { return first[slot / W * step + slot % W]; }
  };
  // Empty slots hold a particle at rest of no volume.
  Channel x[3], F[9], volume;  // [cells], row-major, rest volume [m^3]
  Channel strength;            // [Pa], when some row is plasticine
  Channel elasticity[3];       // mu, lambda [Pa], density [kg/m^3], when particles have their own
  Channel total_F[9];          // row-major, when tracked
  Buffer<int> particle;        // the callers' index, -1: empty slot
  Channel v[3], C[9];          // m/s, 1/s; valid after load and after the last pass of an interval
  static constexpr std::uint16_t kSeveral = 0xffff;
  // What the lanes of a register of slots have in common.
  struct Register {
    int row = -1;               // of all lanes, -1 when mixed
    LaneBits lanes = 0;         // those that hold particles
    LaneBits leaving = 0;       // of a column: those that are not in their cell any more
    std::int8_t column = -1;    // the block's cell that is the column's lowest, -1: not a column
    std::uint8_t body = 0;      // whose velocity field its particles move with; of all lanes
    std::uint16_t control = 0;  // control group of all particles, kSeveral where they differ
  };
  std::vector<Register> registers;
  bool has_strength = false, has_elasticity = false;
  bool keeps_motion = false;  // v and C go with a particle that moves to another slot

  int slots() const { return slots_; }
  // The numbers of a register of slots, W per channel: x, F, volume, then the optional ones.
  static constexpr int kDeformation = 3, kVolume = 12;
  PHYSMAS_INLINE T* numbers(int reg) { return numbers_.data() + static_cast<size_t>(reg) * channels_ * W; }
  // Brings them into the nearest cache only, since others are full of nodes, for reading or writing. No register need
  // be there.
  PHYSMAS_INLINE void prefetch(int reg) const {
    const T* at = numbers_.data() + static_cast<size_t>(reg) * channels_ * W;
    for (int c = 0; c < channels_; ++c) __builtin_prefetch(at + c * W, 0, 0);
    __builtin_prefetch(particle.data() + static_cast<size_t>(reg) * W, 1);
  }
  size_t bytes() const;

 private:
  struct Slot {
    int reg = -1, lane = 0;  // register, -1: none
  };
  Slot column_place(int begin, int end, int reg, int lane);
  Slot loose_particle(int begin, int end, int reg, int lane);
  Slot loose_place(int begin, int end, const Register& home) const;
  void move(int reg, int lane, const Slot& to);
  void place();
  // Where an empty slot's particle rests [cells]: inside its cell of a column, so that it does not stray.
  T rest(int slot, int axis) const {
    const int column = registers[slot / W].column;
    if (column < 0) return T(2);
    const int cell = column + slot % W / kColumnSlots;
    return T(1 + (axis == 0 ? cell / (kBlock * kBlock) : axis == 1 ? cell / kBlock % kBlock : cell % kBlock));
  }
  std::uint16_t control_of(int i) const { return has_controls_ ? setup_.control_group[i] : std::uint16_t(0); }
  template <class Function>
  void for_each_register(int b, const Function& function) const;
  void bind();
  // What the lanes of a register have in common. from: per lane, the arrival that it holds, or null; held: its
  // particle.
  void describe(int reg, const Arrival* const* from, const int* held);
  // Calls function(channel, what an empty slot holds).
  template <class Function>
  void for_each_channel(const Function& function) {
    for (auto& c : x) function(c, T(2));
    for (int k = 0; k < 9; ++k) function(F[k], T(k % 4 == 0));
    function(volume, T(0));
    if (has_strength) function(strength, T(1));
    for (auto& c : elasticity) {
      if (has_elasticity) function(c, T(1));
    }
    for (int k = 0; setup_.track_total_F && k < 9; ++k) function(total_F[k], T(k % 4 == 0));
  }

  static constexpr int kPrefetchSort = 32;  // registers

  const StepperSetup& setup_;
  Team& team_;
  double dx_, safe_cells_;
  int slots_ = 0;
  bool has_controls_ = false;
  std::vector<Arrival> arrivals_;  // in the order of the blocks
  // Where particles go in a sort: the cell in the new block, and which block that is.
  struct Departure {
    std::uint8_t cell, code;
  };
  std::vector<Departure> departures_;    // per slot
  std::vector<BlockLayout<W>> layouts_;  // per block; indices count from the block's first arrival
  int channels_ = 0;
  std::vector<T> empty_;  // the numbers of a register of empty slots
  // What lives from substep to substep; and where sorting puts it, which between intervals keeps v and C instead.
  Buffer<T> numbers_, other_;
  Buffer<int> spare_particle_;
};

template <class T>
ParticleStore<T>::ParticleStore(const StepperSetup& setup, Team& team, double safe_cells)
    : map(setup.domain.n + 1), setup_(setup), team_(team), dx_(setup.domain.dx()), safe_cells_(safe_cells) {
  for (const int row : setup.row) has_strength = has_strength || setup.branches[row] == Branch::plasticine;
  has_elasticity = !setup.elasticity.empty();
  for (const std::uint16_t group : setup.control_group) has_controls_ = has_controls_ || group != 0;
  for_each_channel([&](Channel&, T empty) {
    empty_.insert(empty_.end(), W, empty);
    ++channels_;
  });
}

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
    cell[i] = static_cast<std::uint8_t>((inside[0] * kBlock + inside[1]) * kBlock + inside[2]);
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
  for (int i = 0; i < count; ++i) arrivals_[next[map.index_of(id[i])]++] = {i, setup_.row[i], cell[i], Arrival::kStay};
  place();

  numbers_.resize(static_cast<size_t>(slots_) * channels_);
  other_.resize(static_cast<size_t>(slots_) * channels_);
  bind();
  particle.resize(slots_);
  team_.for_each(static_cast<int>(map.particle_blocks.size()), [&](int b) {
    const ParticleBlock& block = map.particle_blocks[b];
    for_each_register(b, [&](int reg, const Arrival* const* from) {
      for (int l = 0; l < W; ++l) {
        const int s = reg * W + l, i = from[l] ? from[l]->source : -1;
        const bool real = i >= 0;
        particle[s] = i;
        volume[s] = real ? T(setup_.volume[i]) : T(0);
        if (has_strength) strength[s] = real ? T(state.strength[i]) : T(1);
        if (has_elasticity) {
          elasticity[0][s] = real ? T(setup_.elasticity[i].mu) : T(1);
          elasticity[1][s] = real ? T(setup_.elasticity[i].lambda) : T(1);
          elasticity[2][s] = real ? T(setup_.elasticity[i].density) : T(1);
        }
        for (int a = 0; a < 3; ++a) {
          x[a][s] = real ? T(cells_at(i, a) - kBlock * block.position[a]) : rest(s, a);
          v[a][s] = real ? T(state.v[i][a]) : T(0);
        }
        for (int k = 0; k < 9; ++k) {
          F[k][s] = real ? T(state.F[i][k / 3][k % 3]) : T(k % 4 == 0);
          C[k][s] = real ? T(state.C[i][k / 3][k % 3]) : T(0);
          if (setup_.track_total_F) total_F[k][s] = real ? T(state.total_F[i][k / 3][k % 3]) : T(k % 4 == 0);
        }
      }
      describe(reg, from, &particle[reg * W]);
    });
  });
  return clamped;
}

template <class T>
void ParticleStore<T>::store(State& state) const {
  team_.for_each(static_cast<int>(map.particle_blocks.size()), [&](int b) {
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

// From arrivals_ and the blocks' counts: slots, and what they will hold.
template <class T>
void ParticleStore<T>::place() {
  const int blocks = static_cast<int>(map.particle_blocks.size());
  if (blocks > static_cast<int>(layouts_.size())) layouts_.resize(blocks);
  team_.for_each(blocks, [&](int b) {
    ParticleBlock& block = map.particle_blocks[b];
    layouts_[b].lay_out(arrivals_.data() + block.first, setup_.contact, block);
  });
  slots_ = 0;
  for (ParticleBlock& block : map.particle_blocks) {
    block.begin = slots_;
    slots_ += block.slots;
  }
  registers.resize(slots_ / W);
  for (int b = 0; b < blocks; ++b) {
    Register* at = &registers[map.particle_blocks[b].begin / W];
    for (const int column : layouts_[b].column) (at++)->column = static_cast<std::int8_t>(column);
  }
  map.connect(team_.threads());
}

template <class T>
void ParticleStore<T>::describe(int reg, const Arrival* const* from, const int* held) {
  int row = -1;
  bool mixed = false;
  std::uint16_t control = 0;
  LaneBits lanes = 0;
  for (int l = 0; l < W; ++l) {
    if (!from[l]) continue;
    mixed = mixed || (lanes != 0 && from[l]->row != row);
    row = from[l]->row;
    const std::uint16_t own = control_of(held[l]);
    control = lanes == 0 || control == own ? own : kSeveral;
    lanes |= LaneBits(1) << l;
  }
  Register& home = registers[reg];
  home.row = mixed ? -1 : row;
  home.lanes = lanes;
  home.leaving = 0;
  home.control = control;
  home.body = row >= 0 ? static_cast<std::uint8_t>(setup_.contact.of(row)) : 0;
}

// Calls function(reg, from) for all registers of block b, from[l] the arrival that lane l will hold, or null.
template <class T>
template <class Function>
void ParticleStore<T>::for_each_register(int b, const Function& function) const {
  const ParticleBlock& block = map.particle_blocks[b];
  const Arrival* const first = arrivals_.data() + block.first;
  const int* index = layouts_[b].from.data();
  for (int reg = block.begin / W; reg < (block.begin + block.slots) / W; ++reg, index += W) {
    const Arrival* from[W];
    for (int l = 0; l < W; ++l) from[l] = index[l] >= 0 ? first + index[l] : nullptr;
    function(reg, from);
  }
}

// Channels lie one after the other in each register's numbers.
template <class T>
void ParticleStore<T>::bind() {
  if (slots_ == 0) return;
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

#include "mpm/cpu/column_moves.h"
#include "mpm/cpu/particle_sort.h"

#endif
