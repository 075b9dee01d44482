// The background grid: turns the momentum that particles brought into velocity, applies gravity, lets bodies meet, then
// colliders and walls. Only blocks of nodes that particles reach are touched, and of those, for every body, the ones
// that its particles reach.
#ifndef PHYSMAS_MPM_CPU_GRID_H
#define PHYSMAS_MPM_CPU_GRID_H

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "base/team.h"
#include "mpm/action/collider.h"
#include "mpm/body_contact.h"
#include "mpm/cpu/blocks.h"
#include "mpm/cpu/buffer.h"
#include "mpm/cpu/grid_layout.h"
#include "mpm/energy_budget.h"
#include "mpm/rigid/rigid_motion.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm {

template <class T>
class Grid {
 public:
  // All of them outlive the grid.
  Grid(const StepperSetup& setup, Team& team, const BlockMap& map)
      : layout(setup.domain.n + 1),
        setup_(setup),
        team_(team),
        map_(map),
        dx_(setup.domain.dx()),
        fields_(setup.contact.bodies()) {
    for (Field& field : fields_) {
      field.velocity.resize(layout.numbers() + kApart);
      field.momentum.resize(layout.numbers());
      if (setup.measure_steps) field.force_free.resize(layout.numbers());
    }
  }

  const GridLayout layout;

  // After every sort.
  void prepare();
  // Per rigid body: whether an obstacle or another body is near.
  std::vector<char> near_rigid() const;
  // {0, vx, vy, vz} of a body's nodes, from the first node of a particle block on.
  const T* velocity(const ParticleBlock& block, int body) const {
    return fields_[body].velocity.data() + kApart + offset(block.position);
  }
  // {m, m vx, m vy, m vz} to add to. Zero before the first particle brings something.
  T* momentum(const ParticleBlock& block, int body) { return fields_[body].momentum.data() + offset(block.position); }
  // The same without the momentum of the forces; when energy is measured.
  T* force_free(const ParticleBlock& block, int body) {
    return fields_[body].force_free.data() + offset(block.position);
  }
  // Updates all active nodes and clears their momentum; returns the largest velocity component [m/s]. energy: filled
  // when measured.
  double update(double dt, GridEnergy& energy);
  // The same where some bodies are rigid, which it moves, or are let go for an impact. push: what contact does to each
  // of the latter, added up [kg m/s]. False: bodies run into something and are to be let go first; nothing has changed.
  bool update(double dt, bool fresh, RigidMotion& rigid, double& speed, std::vector<Vec3d>& push, GridEnergy& energy);
  // Clears all active nodes.
  void clear();
  size_t bytes() const {
    size_t blocks = 0;
    for (const GridBlock& block : map_.grid_blocks) blocks += __builtin_popcount(block.bodies);
    return (setup_.measure_steps ? 3 : 2) * blocks * kBlockNodes * 4 * sizeof(T);
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
  void prepare_rigid();
  typedef T Nodes __attribute__((vector_size(kNodeRow * sizeof(T))));  // of one node row
  // Grid update: what nodes have received, {m, p}, to {0, u}, and a fall by gravity [m/s].
  static PHYSMAS_INLINE Nodes grid_update(const Nodes& received, const Nodes& fall);
  // Where bodies may meet: the gradients of their masses at the nodes that several have reached. Before any node is
  // cleared, since they look at neighbours.
  void find_meetings();
  void find_meetings(int index, int meeting);
  // Contact between bodies at the nodes of a block. received: {m, …} per body and node; nodes: {0, u} likewise.
  void meet_at_nodes(int meeting, const T* const* received, T* const* nodes) const;
  // Contact with obstacles: colliders, then walls. nodes: {0, u} of a block, changed. Nodes without mass, of which
  // nobody asks, are left alone. received: {m, …} per node.
  void contact(const GridBlock& block, const T* received, T* nodes) const;
  template <bool kMeasure, bool kMeets>
  double update_block(int index, double dt);
  // The same for block r of those that rigid bodies reach, in two halves.
  struct RigidBlock;
  struct RigidNodes;
  void find_held_nodes(RigidBlock& block) const;
  void gather_nodes(const RigidBlock& block, double dt, RigidNodes& nodes) const;
  void collect(RigidBlock& block, RigidNodes& nodes, double dt, const RigidMotion& rigid) const;
  template <bool kMeasure>
  double update_rigid_block(RigidBlock& block, RigidNodes& nodes, double dt, const RigidMotion& rigid);
  void measure_rigid_nodes(const RigidBlock& block, const RigidNodes& nodes, const double (&left)[3][kBlockNodes],
                           const double (&locked)[3][kBlockNodes], bool held);

  static constexpr int kChunk = 8;  // blocks that a thread takes at once: one alone is less than a microsecond

  const StepperSetup& setup_;
  Team& team_;
  const BlockMap& map_;
  double dx_;
  // Read for every register; on lines of cache of its own, so that no thread writes beside it.
  struct alignas(128) Field {
    Buffer<T> velocity, momentum, force_free;
  };
  std::vector<Field> fields_;  // per body
  // Blocks that several bodies reach, and per body, node and axis of each the gradient of its mass [kg per cell].
  std::vector<int> meetings_, meeting_of_;  // indices of active blocks; per active block, -1: none
  std::vector<int> meeting_bounds_;         // of the threads' blocks
  std::vector<T> mass_gradients_;
  std::vector<std::uint8_t> obstacle_;    // per active block: a wall or collider may touch it
  std::vector<int> chunk_bounds_;         // of the threads' chunks of blocks
  std::vector<double> speed_;             // per active block: largest velocity component [m/s]
  std::vector<GridEnergy> energy_;        // per active block, when measured
  std::vector<RigidBlock> rigid_blocks_;  // those that rigid bodies reach
  std::vector<RigidNodes> rigid_nodes_;   // of each
  std::vector<int> rigid_block_of_;       // per active block, -1: none
  RigidSystem rigid_system_;
};

template <class T>
void Grid<T>::prepare() {
  energy_.assign(map_.grid_blocks.size(), {});
  speed_.assign(map_.grid_blocks.size(), 0);
  obstacle_.assign(map_.grid_blocks.size(), 0);
  for (size_t b = 0; b < obstacle_.size(); ++b) {
    const int* const at = map_.grid_blocks[b].position;
    const int first[3] = {kBlock * at[0], kBlock * at[1], kBlock * at[2]};
    obstacle_[b] = near_obstacle(setup_.domain, first, kBlock);
  }
  const int chunks = (static_cast<int>(map_.grid_blocks.size()) + kChunk - 1) / kChunk;
  // Where one thread has all particles, waking another takes longer than the grid.
  chunk_bounds_ = Team::even_ranges(chunks, map_.shared() ? team_.threads() : 1);
  chunk_bounds_.resize(team_.threads() + 1, chunks);
  meetings_.clear();
  if (fields_.size() == 1) return;
  if (!setup_.rigid.empty()) return prepare_rigid();
  meeting_of_.assign(map_.grid_blocks.size(), -1);
  for (size_t b = 0; b < map_.grid_blocks.size(); ++b) {
    if (__builtin_popcount(map_.grid_blocks[b].bodies) < 2) continue;
    meeting_of_[b] = static_cast<int>(meetings_.size());
    meetings_.push_back(static_cast<int>(b));
  }
  const int meetings = static_cast<int>(meetings_.size());
  meeting_bounds_ = Team::even_ranges(meetings, map_.shared() ? team_.threads() : 1);
  meeting_bounds_.resize(team_.threads() + 1, meetings);
  mass_gradients_.resize(meetings_.size() * fields_.size() * kBlockNodes * 3);
}

template <class T>
void Grid<T>::clear() {
  for (const GridBlock& block : map_.grid_blocks) {
    for_each_node_row(block, [&](int, size_t at) {
      for (size_t f = 0; f < fields_.size(); ++f) {
        if ((block.bodies >> f & 1) == 0) continue;
        Field& field = fields_[f];
        std::memset(field.velocity.data() + kApart + at, 0, kNodeRow * sizeof(T));
        std::memset(field.momentum.data() + at, 0, kNodeRow * sizeof(T));
        if (setup_.measure_steps) std::memset(field.force_free.data() + at, 0, kNodeRow * sizeof(T));
      }
    });
  }
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

template <class T>
void Grid<T>::find_meetings() {
  if (meetings_.empty()) return;
  team_.for_each(meeting_bounds_, [&](int m) { find_meetings(meetings_[m], m); });
}

template <class T>
void Grid<T>::find_meetings(int index, int meeting) {
  const GridBlock& block = map_.grid_blocks[index];
  T* const gradients = mass_gradients_.data() + static_cast<size_t>(meeting) * fields_.size() * kBlockNodes * 3;
  const std::ptrdiff_t step[3] = {layout.step_x(), layout.step_y(), 4};
  for_each_node_row(block, [&](int r, size_t at) {
    for (int z = 0; z < kBlock; ++z) {
      const size_t node = at + 4 * z;
      int there = 0;
      for (const Field& field : fields_) there += field.momentum[node] > T(0);
      if (there < 2) continue;
      for (size_t f = 0; f < fields_.size(); ++f) {
        const T* const mass = fields_[f].momentum.data() + node;
        if (!(*mass > T(0))) continue;
        T* const to = gradients + (f * kBlockNodes + kBlock * r + z) * 3;
        for (int axis = 0; axis < 3; ++axis) to[axis] = T(0.5) * (mass[step[axis]] - mass[-step[axis]]);
      }
    }
  });
}

template <class T>
void Grid<T>::meet_at_nodes(int meeting, const T* const* received, T* const* nodes) const {
  const T* const gradients = mass_gradients_.data() + static_cast<size_t>(meeting) * fields_.size() * kBlockNodes * 3;
  const int fields = static_cast<int>(fields_.size());
  for (int i = 0; i < kBlockNodes; ++i) {
    BodyAtNode here[kMostBodies];
    int body[kMostBodies], count = 0;
    for (int f = 0; f < fields; ++f) {
      if (!received[f] || !(received[f][4 * i] > T(0))) continue;
      const T* const g = gradients + (f * kBlockNodes + i) * 3;
      const T* const u = nodes[f] + 4 * i;
      here[count] = {received[f][4 * i], {g[0], g[1], g[2]}, {u[1], u[2], u[3]}};
      body[count++] = f;
    }
    if (count < 2) continue;
    meet(here, count, setup_.contact.friction);
    for (int k = 0; k < count; ++k) {
      for (int axis = 0; axis < 3; ++axis) nodes[body[k]][4 * i + 1 + axis] = T(here[k].u[axis]);
    }
  }
}

// The phases between P2G and G2P, node row by node row while they are at hand. kMeets: several bodies reach the block.
template <class T>
template <bool kMeasure, bool kMeets>
double Grid<T>::update_block(int index, double dt) {
  constexpr int kFields = kMeets ? kMostBodies : 1;
  const GridBlock& block = map_.grid_blocks[index];
  Nodes nodes[kFields][kBlock * kBlock];
  alignas(64) T arrived[kFields][kMeasure ? 4 * kBlockNodes : 1], free[kFields][kMeasure ? 4 * kBlockNodes : 1];
  alignas(64) T received[kFields][4 * kBlockNodes];  // where obstacles or other bodies are
  const bool obstacle = obstacle_[index] != 0;
  const Vec3d& g = setup_.domain.gravity;
  const T gx = T(dt * g.x), gy = T(dt * g.y), gz = T(dt * g.z);
  const Nodes fall = {0, gx, gy, gz, 0, gx, gy, gz, 0, gx, gy, gz, 0, gx, gy, gz};
  Nodes largest = {};
  const auto see = [&](const Nodes& u) PHYSMAS_LAMBDA_INLINE {
    const Nodes size = u < 0 ? -u : u;
    largest = size > largest ? size : largest;
  };
  const int only = __builtin_ctz(block.bodies);
  // Calls function(k, field) for every body that reaches the block, k its place in the arrays above.
  const auto for_each_field = [&](const auto& function) PHYSMAS_LAMBDA_INLINE {
    if constexpr (kMeets) {
      for (unsigned left = block.bodies; left != 0; left &= left - 1)
        function(__builtin_ctz(left), fields_[__builtin_ctz(left)]);
    } else {
      function(0, fields_[only]);
    }
  };
  const size_t ahead = static_cast<size_t>(index) + 2;
  if (ahead < map_.grid_blocks.size()) {
    const Field& next = fields_[__builtin_ctz(map_.grid_blocks[ahead].bodies)];
    for_each_node_row(map_.grid_blocks[ahead], [&](int, size_t at) PHYSMAS_LAMBDA_INLINE {
      __builtin_prefetch(next.momentum.data() + at, 1);
      __builtin_prefetch(next.velocity.data() + kApart + at, 1);
    });
  }
  for_each_field([&](int k, Field& field) PHYSMAS_LAMBDA_INLINE {
    for_each_node_row(block, [&](int r, size_t at) PHYSMAS_LAMBDA_INLINE {
      Nodes u;
      std::memcpy(&u, field.momentum.data() + at, sizeof(u));
      std::memset(field.momentum.data() + at, 0, sizeof(u));
      if (kMeets || obstacle) std::memcpy(received[k] + kNodeRow * r, &u, sizeof(u));
      if constexpr (kMeasure) {
        std::memcpy(arrived[k] + kNodeRow * r, field.force_free.data() + at, sizeof(u));
        std::memset(field.force_free.data() + at, 0, sizeof(u));
      }
      u = grid_update(u, fall);
      see(u);
      nodes[k][r] = u;
    });
    if constexpr (kMeasure) std::memcpy(free[k], nodes[k], sizeof(nodes[k]));
  });
  if constexpr (kMeets) {
    const T* masses[kFields] = {};
    T* velocities[kFields] = {};
    for_each_field([&](int k, Field&) {
      masses[k] = received[k];
      velocities[k] = reinterpret_cast<T*>(nodes[k]);
    });
    meet_at_nodes(meeting_of_[index], masses, velocities);
  }
  if (kMeets || obstacle) {
    largest = Nodes{};
    for_each_field([&](int k, Field&) {
      if (obstacle) contact(block, received[k], reinterpret_cast<T*>(nodes[k]));
      for (const Nodes& u : nodes[k]) see(u);
    });
  }
  if constexpr (kMeasure) energy_[index] = {};
  for_each_field([&](int k, Field& field) PHYSMAS_LAMBDA_INLINE {
    for_each_node_row(block, [&](int r, size_t at) {
      std::memcpy(field.velocity.data() + kApart + at, &nodes[k][r], sizeof(nodes[k][r]));
    });
    if constexpr (kMeasure) {
      const T* const numbers = reinterpret_cast<const T*>(nodes[k]);
      for (int i = 0; i < kBlockNodes; ++i)
        measure_node(arrived[k] + 4 * i, free[k] + 4 * i, numbers + 4 * i, energy_[index]);
    }
  });
  T speed = 0;
  for (int k = 0; k < kNodeRow; ++k) speed = largest[k] > speed ? largest[k] : speed;
  return double(speed);
}

template <class T>
double Grid<T>::update(double dt, GridEnergy& energy) {
  const int count = static_cast<int>(map_.grid_blocks.size());
  const auto update = [&](int b) {
    const bool meets = !meetings_.empty() && meeting_of_[b] >= 0;
    if (setup_.measure_steps) return meets ? update_block<true, true>(b, dt) : update_block<true, false>(b, dt);
    return meets ? update_block<false, true>(b, dt) : update_block<false, false>(b, dt);
  };
  find_meetings();
  team_.for_each(chunk_bounds_, [&](int chunk) {
    for (int b = chunk * kChunk; b < std::min(count, (chunk + 1) * kChunk); ++b) speed_[b] = update(b);
  });
  if (setup_.measure_steps) {
    for (const GridEnergy& e : energy_) energy.add(e);
  }
  double speed = 0;
  for (const double s : speed_) speed = std::max(speed, s);
  return speed;
}

}  // namespace physmas::mpm

#include "mpm/cpu/grid_rigid.h"

#endif
