// The solver's own order of the particles: nothing is lost or mixed up by moves between registers and by sorting.
#include "mpm/cpu/particle_store.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace physmas;
using namespace physmas::mpm;

namespace {

constexpr double kSafe = 2;  // cells

// Particles of two rows, eight per cell and more of them at one end, in some cells of a grid of 16.
struct Scene {
  mutable Team team{2};
  StepperSetup setup;
  State state;

  explicit Scene(std::mt19937& random) {
    setup.domain.n = 16;
    setup.branches = {Branch::jelly, Branch::plasticine};
    setup.parameters.resize(2);
    std::uniform_real_distribution<double> unit(0, 1);
    const double dx = setup.domain.dx();
    for (int i = 0; i < 6000; ++i) {
      const Vec3d cells = {4 + 8 * unit(random), 4 + 8 * unit(random), 4 + 8 * unit(random) * unit(random)};
      state.x.push_back({cells.x * dx, cells.y * dx, cells.z * dx});
      setup.row.push_back(cells.x + cells.y > 16 ? 1 : 0);
      setup.volume.push_back(1 + i);
      setup.control_group.push_back(i % 97 == 0 ? 1 : 0);
    }
    const size_t count = state.x.size();
    state.v.assign(count, {0, 0, 0});
    state.F.resize(count);
    state.C.assign(count, diagonal(0.0, 0.0, 0.0));
    // Whole numbers that float keeps exactly, other ones for every particle.
    for (size_t i = 0; i < count; ++i) {
      for (int k = 0; k < 9; ++k) state.F[i][k / 3][k % 3] = static_cast<double>(9 * i + k);
      state.strength.push_back(static_cast<double>(7 * i));
    }
  }
};

// What holds for every store: each particle once, with its own numbers; registers described as they are; the particles
// of columns in their cells. Returns the share of particles in columns.
template <class T>
double check_store(ParticleStore<T>& store, const Scene& scene) {
  constexpr int W = kLanes<T>;
  std::vector<int> seen(scene.state.size());
  int wrong_numbers = 0, wrong_registers = 0, outside = 0, in_columns = 0, tired = 0;
  for (const ParticleBlock& block : store.map.particle_blocks) {
    for (int s = block.begin; s < block.begin + block.slots; ++s) {
      const auto& home = store.registers[s / W];
      const int i = store.particle[s];
      const bool held = (home.lanes >> (s % W) & 1) != 0;
      wrong_registers += held != (i >= 0) || home.leaving != 0;
      Vec3d x = {double(store.x[0][s]), double(store.x[1][s]), double(store.x[2][s])};
      if (home.column >= 0) {
        const int cell = home.column + s % W / kColumnSlots;
        const int corner[3] = {cell / (kBlock * kBlock), cell / kBlock % kBlock, cell % kBlock};
        // Empty lanes rest there, too: they must not look as if they had left.
        for (int a = 0; a < 3; ++a) outside += std::floor(x[a] - 0.5) != corner[a];
      }
      if (i < 0) {
        tired += store.volume[s] != T(0) || store.F[0][s] != T(1) || store.F[1][s] != T(0);
        continue;
      }
      ++seen[i];
      in_columns += home.column >= 0;
      wrong_registers += home.row >= 0 && home.row != scene.setup.row[i];
      wrong_registers += home.column >= 0 && home.row < 0;
      wrong_registers += home.control != store.kSeveral && home.control != scene.setup.control_group[i];
      wrong_numbers += store.volume[s] != T(scene.setup.volume[i]) || store.strength[s] != T(scene.state.strength[i]);
      for (int k = 0; k < 9; ++k) wrong_numbers += store.F[k][s] != T(scene.state.F[i][k / 3][k % 3]);
    }
  }
  CHECK(*std::min_element(seen.begin(), seen.end()) == 1);
  CHECK(*std::max_element(seen.begin(), seen.end()) == 1);
  CHECK(wrong_numbers == 0);
  CHECK(wrong_registers == 0);
  CHECK(outside == 0);
  CHECK(tired == 0);
  return static_cast<double>(in_columns) / static_cast<double>(seen.size());
}

// Moves every particle a little, marks the columns' strays and finds places for them, as a substep does.
template <class T>
int wander(ParticleStore<T>& store, double far, std::mt19937& random) {
  constexpr int W = kLanes<T>;
  std::uniform_real_distribution<double> step(-far, far);
  int left = 0;
  for (size_t b = 0; b < store.map.particle_blocks.size(); ++b) {
    const ParticleBlock& block = store.map.particle_blocks[b];
    for (int reg = block.begin / W; reg < (block.begin + block.slots) / W; ++reg) {
      auto& home = store.registers[reg];
      for (int l = 0; l < W; ++l) {
        if ((home.lanes >> l & 1) == 0) continue;
        const int cell = home.column + l / kColumnSlots;
        const int corner[3] = {cell / (kBlock * kBlock), cell / kBlock % kBlock, cell % kBlock};
        for (int a = 0; a < 3; ++a) {
          T& x = store.x[a][reg * W + l];
          x += T(step(random));
          if (home.column >= 0 && std::floor(x - T(0.5)) != corner[a]) home.leaving |= LaneBits(1) << l;
        }
      }
      left += __builtin_popcount(home.leaving);
    }
    store.leave_columns(static_cast<int>(b));
  }
  return left;
}

template <class T>
void check_moves() {
  std::mt19937 random(3);
  const Scene scene(random);
  ParticleStore<T> store(scene.setup, scene.team, kSafe);
  CHECK(store.load(scene.state) == 0);
  const double columns = check_store(store, scene);
  int left = 0;
  for (int round = 0; round < 3; ++round) {
    for (int step = 0; step < 12; ++step) {
      left += wander(store, 0.05, random);
      check_store(store, scene);
    }
    State before = scene.state, after = scene.state;
    store.store(before);
    store.sort();
    check_store(store, scene);
    store.store(after);
    double moved = 0;
    for (size_t i = 0; i < before.size(); ++i) {
      for (int a = 0; a < 3; ++a) moved = std::max(moved, std::fabs(after.x[i][a] - before.x[i][a]));
    }
    // From one block's first node to another's: half a unit of the last place of 16 cells.
    CHECK(moved <= scene.setup.domain.dx() * 16 * std::numeric_limits<T>::epsilon());
  }
  if (kLanes<T> >= 2 * kColumnSlots) {
    CHECK(columns > 0.3);
    CHECK(left > 1000);
  }
}

}  // namespace

TEST_CASE("mpm particle store: particles keep their numbers when they leave columns and when they are sorted") {
  check_moves<float>();
  check_moves<double>();
}

TEST_CASE("mpm particle store: a register whose strays find no place is no column any more") {
  std::mt19937 random(5);
  const Scene scene(random);
  ParticleStore<float> store(scene.setup, scene.team, kSafe);
  store.load(scene.state);
  constexpr int W = kLanes<float>;
  int columns = 0, left = 0;
  for (size_t b = 0; b < store.map.particle_blocks.size(); ++b) {
    const ParticleBlock& block = store.map.particle_blocks[b];
    // All particles of all columns leave the block's cells at once.
    for (int reg = block.begin / W; reg < (block.begin + block.slots) / W; ++reg) {
      auto& home = store.registers[reg];
      if (home.column < 0) continue;
      ++columns;
      home.leaving = home.lanes;
      for (int l = 0; l < W; ++l) {
        if ((home.lanes >> l & 1) != 0) store.x[0][reg * W + l] = 4.75f;
      }
    }
    store.leave_columns(static_cast<int>(b));
    for (int reg = block.begin / W; reg < (block.begin + block.slots) / W; ++reg) {
      const auto& home = store.registers[reg];
      CHECK(home.leaving == 0);
      left += home.column >= 0;
    }
  }
  if (W >= 2 * kColumnSlots) {
    CHECK(columns > 20);
    CHECK(left < columns);
  }
  check_store(store, scene);
}
