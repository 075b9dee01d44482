// The background grid: sums what particle blocks scattered, turns momentum into velocity, applies gravity, colliders
// and walls. Only blocks of nodes that particles reach are touched.
#ifndef PHYSMAS_MPM_GRID_H
#define PHYSMAS_MPM_GRID_H

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "mpm/blocks.h"
#include "mpm/buffer.h"
#include "mpm/collider.h"
#include "mpm/energy_budget.h"
#include "mpm/row.h"
#include "mpm/stepper.h"

namespace physmas::mpm {

// T numbers per arena; the last row of a stencil may be read four nodes further.
constexpr size_t kArenaNumbers = 4 * kArenaNodes + 16;

template <class T>
class Grid {
 public:
  // setup and map outlive the grid.
  Grid(const StepperSetup& setup, const BlockMap& map) : setup_(setup), map_(map), dx_(setup.domain.dx()) {
    velocity_.resize(static_cast<size_t>(map.grid_block_count()) * kBlockNodes * 4);
  }

  // After every sort.
  void prepare();
  // The nodes of particle block `index` of the map, {m, m vx, m vy, m vz} each, to scatter into.
  T* arena(int index) { return arenas_.data() + static_cast<size_t>(index) * kArenaNumbers; }
  // The same without the momentum of the forces; when energy is measured.
  T* force_free_arena(int index) { return force_free_.data() + static_cast<size_t>(index) * kArenaNumbers; }
  // Copies the velocities that a block's particles reach now, {0, vx, vy, vz} per node, to arena places.
  void load_velocities(const ParticleBlock& block, T* arena) const;
  // Updates all active nodes; returns the largest velocity component [m/s]. energy: filled when measured.
  double update(double dt, GridEnergy& energy);
  size_t bytes() const {
    return (arenas_.size() + force_free_.size() + map_.grid_blocks.size() * kBlockNodes * 4) * sizeof(T);
  }

 private:
  using R = Row<T>;

  bool near_obstacle(const GridBlock& block) const;
  void collect(const GridBlock& block, const Buffer<T>& arenas, T* nodes) const;
  void apply_obstacles(const GridBlock& block, T* nodes) const;
  template <bool kMeasure>
  double update_block(int index, double dt);

  const StepperSetup& setup_;
  const BlockMap& map_;
  double dx_;
  Buffer<T> velocity_;  // blocks of 4^3 nodes of {0, vx, vy, vz}
  Buffer<T> arenas_, force_free_;
  std::vector<std::uint8_t> obstacle_;  // per active block: a wall or collider may touch it
  std::vector<double> speed_;           // per active block: largest velocity component [m/s]
  std::vector<GridEnergy> energy_;      // per active block, when measured
};

template <class T>
void Grid<T>::prepare() {
  arenas_.resize(map_.particle_blocks.size() * kArenaNumbers);
  if (setup_.measure_steps) force_free_.resize(map_.particle_blocks.size() * kArenaNumbers);
  energy_.assign(map_.grid_blocks.size(), {});
  speed_.assign(map_.grid_blocks.size(), 0);
  obstacle_.assign(map_.grid_blocks.size(), 0);
  for (size_t b = 0; b < obstacle_.size(); ++b) obstacle_[b] = near_obstacle(map_.grid_blocks[b]);
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

// Sums the arenas that reach a block of nodes in the order of the particle blocks.
template <class T>
void Grid<T>::collect(const GridBlock& block, const Buffer<T>& arenas, T* nodes) const {
  typedef T Node __attribute__((vector_size(4 * sizeof(T))));
  for (int k = block.parts_begin; k < block.parts_end; ++k) {
    const ArenaPart& part = map_.parts[k];
    const ParticleBlock& source = map_.particle_blocks[part.arena];
    int low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::max<int>(part.low[axis], source.now_low[axis] - part.offset[axis]);
      high[axis] = std::min<int>(part.high[axis], source.now_high[axis] - part.offset[axis]);
    }
    if (low[2] > high[2]) continue;
    const T* arena = arenas.data() + static_cast<size_t>(part.arena) * kArenaNumbers;
    const int z = part.offset[2];
    const bool whole = z == 1;
    for (int x = low[0]; x <= high[0]; ++x) {
      for (int y = low[1]; y <= high[1]; ++y) {
        const T* from = arena + 4 * (((x + part.offset[0]) * kArena + y + part.offset[1]) * kArena + z);
        T* to = nodes + 4 * kBlock * (kBlock * x + y);
        if (whole) {
          // All four nodes lie in the arena, zero where nothing came.
          (R::load(to) + R::load(from)).store(to);
          continue;
        }
        for (int node = low[2]; node <= high[2]; ++node) {
          Node a, b;
          std::memcpy(&a, to + 4 * node, sizeof(a));
          std::memcpy(&b, from + 4 * node, sizeof(b));
          a += b;
          std::memcpy(to + 4 * node, &a, sizeof(a));
        }
      }
    }
  }
}

template <class T>
void Grid<T>::apply_obstacles(const GridBlock& block, T* nodes) const {
  const int wall = setup_.domain.wall_cells, far_wall = setup_.domain.n - wall;
  for (int i = 0; i < kBlockNodes; ++i) {
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

template <class T>
template <bool kMeasure>
double Grid<T>::update_block(int index, double dt) {
  const GridBlock& block = map_.grid_blocks[index];
  typedef T Node __attribute__((vector_size(4 * sizeof(T))));
  alignas(64) T nodes[4 * kBlockNodes] = {};
  alignas(64) T arrived[kMeasure ? 4 * kBlockNodes : 1] = {}, free[kMeasure ? 4 * kBlockNodes : 1];
  collect(block, arenas_, nodes);
  if constexpr (kMeasure) collect(block, force_free_, arrived);
  const Vec3d& g = setup_.domain.gravity;
  const Node fall = {T(0), T(dt * g.x), T(dt * g.y), T(dt * g.z)};
  Node largest = {};
  const auto see = [&](const Node& u) {
    const Node size = u < 0 ? -u : u;
    largest = size > largest ? size : largest;
  };
  const bool obstacle = obstacle_[index];
  for (int i = 0; i < kBlockNodes; ++i) {
    Node u;
    std::memcpy(&u, nodes + 4 * i, sizeof(u));
    const T mass = u[0];
    u = u * (mass > T(0) ? T(1) / mass : T(0)) + fall;
    u[0] = 0;
    std::memcpy(nodes + 4 * i, &u, sizeof(u));
    see(u);
  }
  if constexpr (kMeasure) std::memcpy(free, nodes, sizeof(nodes));
  if (obstacle) {
    apply_obstacles(block, nodes);
    largest = Node{};
    for (int i = 0; i < kBlockNodes; ++i) {
      Node u;
      std::memcpy(&u, nodes + 4 * i, sizeof(u));
      see(u);
    }
  }
  std::memcpy(velocity_.data() + static_cast<size_t>(block.id) * kBlockNodes * 4, nodes, sizeof(nodes));
  if constexpr (kMeasure) {
    energy_[index] = {};
    for (int i = 0; i < kBlockNodes; ++i) measure_node(arrived + 4 * i, free + 4 * i, nodes + 4 * i, energy_[index]);
  }
  return std::max({double(largest[1]), double(largest[2]), double(largest[3])});
}

template <class T>
double Grid<T>::update(double dt, GridEnergy& energy) {
  const int count = static_cast<int>(map_.grid_blocks.size());
  constexpr int kChunk = 8;  // a block alone is less than a microsecond
  setup_.team->for_each((count + kChunk - 1) / kChunk, [&](int chunk) {
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

template <class T>
void Grid<T>::load_velocities(const ParticleBlock& block, T* arena) const {
  for (int x = block.now_low[0]; x <= block.now_high[0]; ++x) {
    for (int y = block.now_low[1]; y <= block.now_high[1]; ++y) {
      // Arena node a is node (a + 3) % 4 of neighbour (a + 3) / 4 - 1.
      const int id = block.id + ((x + 3) / 4 - 1) * map_.id_stride(0) + ((y + 3) / 4 - 1) * map_.id_stride(1);
      const T* from = velocity_.data() + static_cast<size_t>(id) * kBlockNodes * 4 +
                      4 * kBlock * (kBlock * ((x + 3) % 4) + (y + 3) % 4);
      T* to = arena + 4 * kArena * (kArena * x + y);
      std::memcpy(to, from - 4 * kBlockNodes + 12, 4 * sizeof(T));
      std::memcpy(to + 4, from, 16 * sizeof(T));
      std::memcpy(to + 20, from + 4 * kBlockNodes, 12 * sizeof(T));
    }
    // The fourth node of a row is read with weight zero, also beyond the last row.
    std::memset(arena + 4 * kArena * (kArena * x + block.now_high[1] + 1), 0, 4 * sizeof(T));
  }
}

}  // namespace physmas::mpm

#endif
