// The background grid: turns the momentum that particles brought into velocity, applies gravity, colliders and walls.
// Only blocks of nodes that particles reach are touched.
#ifndef PHYSMAS_MPM_CPU_GRID_H
#define PHYSMAS_MPM_CPU_GRID_H

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "base/team.h"
#include "mpm/action/collider.h"
#include "mpm/cpu/blocks.h"
#include "mpm/cpu/buffer.h"
#include "mpm/cpu/grid_layout.h"
#include "mpm/energy_budget.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm {

template <class T>
class Grid {
 public:
  // All of them outlive the grid.
  Grid(const StepperSetup& setup, Team& team, const BlockMap& map)
      : layout(setup.domain.n + 1), setup_(setup), team_(team), map_(map), dx_(setup.domain.dx()) {
    velocity_.resize(layout.numbers() + kApart);
    momentum_.resize(layout.numbers());
    if (setup.measure_steps) force_free_.resize(layout.numbers());
  }

  const GridLayout layout;

  // After every sort.
  void prepare();
  // {0, vx, vy, vz} of nodes, from the first node of a particle block on.
  const T* velocity(const ParticleBlock& block) const { return velocity_.data() + kApart + offset(block.position); }
  // {m, m vx, m vy, m vz} to add to. Zero before the first particle brings something.
  T* momentum(const ParticleBlock& block) { return momentum_.data() + offset(block.position); }
  // The same without the momentum of the forces; when energy is measured.
  T* force_free(const ParticleBlock& block) { return force_free_.data() + offset(block.position); }
  // Updates all active nodes and clears their momentum; returns the largest velocity component [m/s]. energy: filled
  // when measured.
  double update(double dt, GridEnergy& energy);
  // Clears all active nodes.
  void clear();
  size_t bytes() const {
    return (setup_.measure_steps ? 3 : 2) * map_.grid_blocks.size() * kBlockNodes * 4 * sizeof(T);
  }

 private:
  static constexpr int kNodeRow = 4 * kBlock;  // numbers of a line of a block's nodes along z
  // Numbers that velocities are moved by in their memory, half a page and a line of cache: a processor that compares
  // the last twelve bits of addresses first would take a read of a node's velocity for one of the momentum just
  // written.
  static constexpr size_t kApart = (2048 + 64) / sizeof(T);

  size_t offset(const int* block) const {
    return layout.offset(kBlock * block[0], kBlock * block[1], kBlock * block[2]);
  }
  // Calls function(r, offset of its first number) for the 16 node rows of a block.
  template <class Function>
  void for_each_node_row(const GridBlock& block, const Function& function) const {
    const size_t first = offset(block.position);
    for (int r = 0; r < kBlock * kBlock; ++r) {
      function(r, first + r / kBlock * layout.step_x() + r % kBlock * layout.step_y());
    }
  }
  bool near_obstacle(const GridBlock& block) const;
  typedef T Nodes __attribute__((vector_size(kNodeRow * sizeof(T))));  // of one node row
  // Grid update: what nodes have received, {m, p}, to {0, u}, and a fall by gravity [m/s].
  static PHYSMAS_INLINE Nodes grid_update(const Nodes& received, const Nodes& fall);
  // Contact: colliders, then walls. nodes: {0, u} of a block, changed. Nodes without mass, of which nobody asks, are
  // left alone. received: {m, …} per node.
  void contact(const GridBlock& block, const T* received, T* nodes) const;
  template <bool kMeasure>
  double update_block(int index, double dt);

  static constexpr int kChunk = 8;  // blocks that a thread takes at once: one alone is less than a microsecond

  const StepperSetup& setup_;
  Team& team_;
  const BlockMap& map_;
  double dx_;
  Buffer<T> velocity_, momentum_, force_free_;
  std::vector<std::uint8_t> obstacle_;  // per active block: a wall or collider may touch it
  std::vector<int> chunk_bounds_;       // of the threads' chunks of blocks
  std::vector<double> speed_;           // per active block: largest velocity component [m/s]
  std::vector<GridEnergy> energy_;      // per active block, when measured
};

template <class T>
void Grid<T>::prepare() {
  energy_.assign(map_.grid_blocks.size(), {});
  speed_.assign(map_.grid_blocks.size(), 0);
  obstacle_.assign(map_.grid_blocks.size(), 0);
  for (size_t b = 0; b < obstacle_.size(); ++b) obstacle_[b] = near_obstacle(map_.grid_blocks[b]);
  const int chunks = (static_cast<int>(map_.grid_blocks.size()) + kChunk - 1) / kChunk;
  // Where one thread has all particles, waking another takes longer than the grid.
  chunk_bounds_ = Team::even_ranges(chunks, map_.shared() ? team_.threads() : 1);
  chunk_bounds_.resize(team_.threads() + 1, chunks);
}

template <class T>
void Grid<T>::clear() {
  for (const GridBlock& block : map_.grid_blocks) {
    for_each_node_row(block, [&](int, size_t at) {
      std::memset(velocity_.data() + kApart + at, 0, kNodeRow * sizeof(T));
      std::memset(momentum_.data() + at, 0, kNodeRow * sizeof(T));
      if (setup_.measure_steps) std::memset(force_free_.data() + at, 0, kNodeRow * sizeof(T));
    });
  }
}

template <class T>
bool Grid<T>::near_obstacle(const GridBlock& block) const {
  const int last_free = setup_.domain.n - setup_.domain.wall_cells;
  Vec3d center{};
  for (int axis = 0; axis < 3; ++axis) {
    const int first = kBlock * block.position[axis];
    if (first <= setup_.domain.wall_cells || first + kBlock - 1 >= last_free) return true;
    center[axis] = (first + 0.5 * (kBlock - 1)) * dx_;
  }
  const double reach = 0.5 * (kBlock - 1) * std::sqrt(3.0) * dx_ * (1 + 1e-9);
  for (const Collider& c : setup_.domain.colliders) {
    if (locate(c, center).distance <= reach) return true;
  }
  return false;
}

// u_a = p_a / m_a (paper, Eq. "gridupdate"), then gravity. A node without mass falls as well; no one sees it.
template <class T>
PHYSMAS_INLINE typename Grid<T>::Nodes Grid<T>::grid_update(const Nodes& received, const Nodes& fall) {
  const Nodes moving = {0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1};
  const Nodes mass = __builtin_shufflevector(received, received, 0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12);
  return received * (mass > T(0) ? moving / mass : Nodes{}) + fall;
}

template <class T>
void Grid<T>::contact(const GridBlock& block, const T* received, T* nodes) const {
  const int wall = setup_.domain.wall_cells, far_wall = setup_.domain.n - wall;
  for (int i = 0; i < kBlockNodes; ++i) {
    if (!(received[4 * i] > T(0))) continue;
    const int index[3] = {kBlock * block.position[0] + i / 16, kBlock * block.position[1] + i / 4 % 4,
                          kBlock * block.position[2] + i % 4};
    T* node = nodes + 4 * i;
    Vec3d u = {node[1], node[2], node[3]};
    const Vec3d x = {index[0] * dx_, index[1] * dx_, index[2] * dx_};
    for (const Collider& c : setup_.domain.colliders) u = apply_contact(c, locate(c, x), u);
    for (int axis = 0; axis < 3; ++axis) {
      if (index[axis] <= wall) u[axis] = at_least(u[axis], 0.0);
      if (index[axis] >= far_wall) u[axis] = at_most(u[axis], 0.0);
      node[1 + axis] = T(u[axis]);
    }
  }
}

// The phases between P2G and G2P, node row by node row while they are at hand.
template <class T>
template <bool kMeasure>
double Grid<T>::update_block(int index, double dt) {
  const GridBlock& block = map_.grid_blocks[index];
  Nodes nodes[kBlock * kBlock];
  alignas(64) T arrived[kMeasure ? 4 * kBlockNodes : 1], free[kMeasure ? 4 * kBlockNodes : 1];
  alignas(64) T received[4 * kBlockNodes];  // where obstacles are
  const bool obstacle = obstacle_[index] != 0;
  const Vec3d& g = setup_.domain.gravity;
  const T gx = T(dt * g.x), gy = T(dt * g.y), gz = T(dt * g.z);
  const Nodes fall = {0, gx, gy, gz, 0, gx, gy, gz, 0, gx, gy, gz, 0, gx, gy, gz};
  Nodes largest = {};
  const auto see = [&](const Nodes& u) PHYSMAS_LAMBDA_INLINE {
    const Nodes size = u < 0 ? -u : u;
    largest = size > largest ? size : largest;
  };
  const size_t ahead = static_cast<size_t>(index) + 2;
  if (ahead < map_.grid_blocks.size()) {
    for_each_node_row(map_.grid_blocks[ahead], [&](int, size_t at) PHYSMAS_LAMBDA_INLINE {
      __builtin_prefetch(momentum_.data() + at, 1);
      __builtin_prefetch(velocity_.data() + kApart + at, 1);
    });
  }
  for_each_node_row(block, [&](int r, size_t at) PHYSMAS_LAMBDA_INLINE {
    Nodes u;
    std::memcpy(&u, momentum_.data() + at, sizeof(u));
    std::memset(momentum_.data() + at, 0, sizeof(u));
    if (obstacle) std::memcpy(received + kNodeRow * r, &u, sizeof(u));
    if constexpr (kMeasure) {
      std::memcpy(arrived + kNodeRow * r, force_free_.data() + at, sizeof(u));
      std::memset(force_free_.data() + at, 0, sizeof(u));
    }
    u = grid_update(u, fall);
    see(u);
    nodes[r] = u;
  });
  T* const numbers = reinterpret_cast<T*>(nodes);
  if constexpr (kMeasure) std::memcpy(free, nodes, sizeof(nodes));
  if (obstacle) {
    contact(block, received, numbers);
    largest = Nodes{};
    for (const Nodes& u : nodes) see(u);
  }
  for_each_node_row(
      block, [&](int r, size_t at) { std::memcpy(velocity_.data() + kApart + at, &nodes[r], sizeof(nodes[r])); });
  if constexpr (kMeasure) {
    energy_[index] = {};
    for (int i = 0; i < kBlockNodes; ++i) measure_node(arrived + 4 * i, free + 4 * i, numbers + 4 * i, energy_[index]);
  }
  T speed = 0;
  for (int k = 0; k < kNodeRow; ++k) speed = largest[k] > speed ? largest[k] : speed;
  return double(speed);
}

template <class T>
double Grid<T>::update(double dt, GridEnergy& energy) {
  const int count = static_cast<int>(map_.grid_blocks.size());
  team_.for_each(chunk_bounds_, [&](int chunk) {
    for (int b = chunk * kChunk; b < std::min(count, (chunk + 1) * kChunk); ++b) {
      speed_[b] = setup_.measure_steps ? update_block<true>(b, dt) : update_block<false>(b, dt);
    }
  });
  if (setup_.measure_steps) {
    for (const GridEnergy& e : energy_) energy.add(e);
  }
  double speed = 0;
  for (const double s : speed_) speed = std::max(speed, s);
  return speed;
}

}  // namespace physmas::mpm

#endif
