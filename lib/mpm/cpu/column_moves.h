// Between sorts: what becomes of particles that leave their cell of a column. Part of particle_store.h.
#ifndef PHYSMAS_MPM_CPU_COLUMN_MOVES_H
#define PHYSMAS_MPM_CPU_COLUMN_MOVES_H

#include <utility>

#include "mpm/cpu/particle_store.h"

namespace physmas::mpm {

template <class T>
void ParticleStore<T>::leave_columns(int block) {
  ParticleBlock& home = map.particle_blocks[block];
  const int first = home.begin / W, columns = first + home.loose, end = first + home.slots / W;
  for (int reg = columns; reg < end; ++reg) {
    const LaneBits leaving = std::exchange(registers[reg].leaving, 0);
    for (LaneBits left = leaving; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      Slot to = column_place(columns, end, reg, lane);
      if (to.reg < 0) {
        to = loose_place(first, columns, registers[reg]);
        home.strayed += 1;
      }
      if (to.reg < 0) {
        registers[reg].column = -1;
        home.strayed += __builtin_popcount(registers[reg].lanes) - 1;
        break;
      }
      move(reg, lane, to);
      const Slot from = loose_particle(first, columns, reg, lane);
      if (from.reg < 0) continue;
      move(from.reg, from.lane, {reg, lane});
      home.strayed -= 1;
    }
  }
}

// A loose particle for a free lane of a column, or none.
template <class T>
typename ParticleStore<T>::Slot ParticleStore<T>::loose_particle(int begin, int end, int reg, int lane) {
  using V = Lanes<T>;
  const Register& to = registers[reg];
  // A free lane rests in the middle of the stencil of its cell.
  const auto cell = [&](int axis) { return V(rest(reg * W + lane, axis) - T(1)); };
  const V x = cell(0), y = cell(1), z = cell(2);
  for (int g = begin; g < end; ++g) {
    const Register& from = registers[g];
    if (from.row != to.row || (from.control != to.control && to.control != kSeveral)) continue;
    const Vec3<V> base = base_of(GridExchange<T>::load(numbers(g)));
    const LaneBits here = lane_bits(base.x == x && base.y == y && base.z == z) & from.lanes;
    if (here != 0) return {g, __builtin_ctz(here)};
  }
  return {};
}

// A free lane of the cell that a particle is in, or none, among columns of its row.
template <class T>
typename ParticleStore<T>::Slot ParticleStore<T>::column_place(int begin, int end, int reg, int lane) {
  constexpr int kCells = W / kColumnSlots;
  if constexpr (kCells >= 2) {
    int cell = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const T place = numbers(reg)[axis * W + lane] - T(0.5);
      if (!(place >= T(0) && place < T(kBlock))) return {};
      cell = cell * kBlock + static_cast<int>(place);
    }
    const int row = registers[reg].row;
    const std::uint16_t own = control_of(particle[reg * W + lane]);
    const LaneBits of_cell = ((LaneBits(1) << kColumnSlots) - 1) << cell % kCells * kColumnSlots;
    for (int g = begin; g < end; ++g) {
      const Register& to = registers[g];
      const LaneBits free = of_cell & ~to.lanes;
      if (to.column != cell / kCells * kCells || free == 0) continue;
      if (to.row == row && (to.control == own || to.control == kSeveral)) return {g, __builtin_ctz(free)};
    }
  }
  return {};
}

// A free lane among loose registers of its body, of its own row if possible.
template <class T>
typename ParticleStore<T>::Slot ParticleStore<T>::loose_place(int begin, int end, const Register& home) const {
  Slot place;
  for (int g = begin; g < end; ++g) {
    const Register& to = registers[g];
    if (to.lanes == kAllLanes<T> || (to.lanes != 0 && to.body != home.body)) continue;
    const bool own_kind = to.lanes == 0 || to.row == home.row;
    if (place.reg < 0 || own_kind) place = {g, __builtin_ctz(~to.lanes)};
    if (own_kind) break;
  }
  return place;
}

template <class T>
void ParticleStore<T>::move(int reg, int lane, const Slot& to) {
  for (int c = 0; c < channels_; ++c) {
    numbers(to.reg)[c * W + to.lane] = numbers(reg)[c * W + lane];
    numbers(reg)[c * W + lane] = empty_[c * W + lane];
  }
  const int slot = reg * W + lane;
  const int place = to.reg * W + to.lane;
  for (int a = 0; keeps_motion && a < 3; ++a) v[a][place] = v[a][slot];
  for (int k = 0; keeps_motion && k < 9; ++k) C[k][place] = C[k][slot];
  const std::uint16_t own = control_of(particle[slot]);
  for (int a = 0; a < 3; ++a) x[a][slot] = rest(slot, a);
  particle[place] = particle[slot];
  particle[slot] = -1;
  Register &old_home = registers[reg], &home = registers[to.reg];
  home.row = home.lanes == 0 || home.row == old_home.row ? old_home.row : -1;
  home.control = home.lanes == 0 || home.control == own ? own : kSeveral;
  home.body = old_home.body;
  home.lanes |= LaneBits(1) << to.lane;
  old_home.lanes &= ~(LaneBits(1) << lane);
}

}  // namespace physmas::mpm

#endif
