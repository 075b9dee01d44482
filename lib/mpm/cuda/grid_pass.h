// The grid between two passes over the particles: velocities of the nodes, gravity, contact of bodies with one another,
// then with colliders and walls (cpu/grid.h is the same on the CPU).
#ifndef PHYSMAS_MPM_CUDA_GRID_PASS_H
#define PHYSMAS_MPM_CUDA_GRID_PASS_H

#include "mpm/action/collider.h"
#include "mpm/body_contact.h"
#include "mpm/cuda/layout.h"

namespace physmas::mpm::PHYSMAS_GPU {

template <class T>
struct GridPassArguments {
  const ActiveBlock* blocks;
  const int* block_count;
  const int* slots;  // [bodies][table.count()], -1: none
  BlockTable table;
  int bodies;
  double friction;  // between them
  NodeSum* sums[2];
  NodeVelocity<T>* velocity;
  SumUnits units;
  const Collider* colliders;
  int collider_count;
  StepRecord* records;
  int step;
  int* ticket;
  Vec3d gravity;
  double dt, dx;
  int n, wall_cells;
};

// kMeets: there are several bodies.
template <class T, bool kMeets>
class GridPass {
 public:
  using Arguments = GridPassArguments<T>;
  static constexpr int kThreads = kBlockNodes, kResident = 8;
  static constexpr int kPhases = 3, kFinalPhases = 1;
  struct Shared {
    decltype(bits_of(T())) speed;  // largest component of a velocity, as bits
  };

  PHYSMAS_DEVICE GridPass(const Arguments& arguments, Shared& shared, int thread)
      : a_(arguments), s_(shared), thread_(thread) {}

  PHYSMAS_DEVICE int items() const { return a_.records[a_.step].grid_due == 0 ? 0 : *a_.block_count; }
  PHYSMAS_DEVICE int* ticket() const { return a_.ticket; }

  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    if constexpr (kPhase == 0) {
      if (thread_ == 0) s_.speed = 0;
    }
    if constexpr (kPhase == 1) update(a_.blocks[item]);
    if constexpr (kPhase == 2) {
      if (thread_ == 0) {
        raise(&a_.records[a_.step].node_speed, bits_of(static_cast<double>(number_of(s_.speed))));
      }
    }
  }

  // Whether the particles may move, or have to be sorted first. Particle velocities are convex combinations of node
  // velocities, so none is faster than the fastest node, unless an action moves it.
  template <int kPhase>
  PHYSMAS_DEVICE void final_phase() {
    StepRecord& record = a_.records[a_.step];
    if (thread_ != 0 || record.grid_due == 0) return;
    const double cells = a_.dt / a_.dx;
    const double by_grid = number_of(fresh(&record.node_speed)) * cells, enforced = record.enforced * cells;
    // Motion that is enforced in one direction only keeps what it has in the others.
    record.next_drift = std::sqrt(by_grid * by_grid + enforced * enforced) + record.raised * cells;
    record.particles_due = record.drift > 0 && !(record.drift + record.next_drift <= kDriftLimit) ? 0 : 1;
  }

 private:
  PHYSMAS_DEVICE double mass_at(const NodeSum* sums, int body, const int* node) const {
    const int id =
        a_.table.id((node[0] + kCells) / kCells - 1, (node[1] + kCells) / kCells - 1, (node[2] + kCells) / kCells - 1);
    const int slot = a_.slots[body * a_.table.count() + id];
    if (slot < 0) return 0;
    const int inside =
        ((node[0] + kCells) % kCells * kCells + (node[1] + kCells) % kCells) * kCells + (node[2] + kCells) % kCells;
    return static_cast<double>(sums[static_cast<size_t>(slot) * kBlockNodes + inside].mass) * a_.units.mass_of_unit;
  }

  PHYSMAS_DEVICE void update(const ActiveBlock& block) {
    constexpr int kFields = kMeets ? kMostBodies : 1;
    const int of_step = a_.records[a_.step].sums;
    const NodeSum* const sums = a_.sums[of_step];
    NodeSum* const next = a_.sums[1 - of_step];
    int position[3], node[3];
    a_.table.locate(block.block, position);
    node[0] = kCells * position[0] + thread_ / (kCells * kCells);
    node[1] = kCells * position[1] + thread_ / kCells % kCells;
    node[2] = kCells * position[2] + thread_ % kCells;
    BodyAtNode here[kFields];
    size_t at[kFields];
    int count = 0;
    for (int body = 0; body < (kMeets ? a_.bodies : 1); ++body) {
      const int slot = a_.slots[body * a_.table.count() + block.block];
      if (slot < 0) continue;
      const size_t index = static_cast<size_t>(slot) * kBlockNodes + thread_;
      next[index] = {};
      const NodeSum sum = sums[index];
      if (sum.mass <= 0) {
        a_.velocity[index] = {};
        continue;
      }
      // In double precision: float would round what gravity adds to a fast node the same way in every substep.
      const double mass = static_cast<double>(sum.mass) * a_.units.mass_of_unit;
      const double scale = a_.units.momentum_of_unit / mass;
      BodyAtNode& node_of_body = here[count];
      node_of_body.mass = mass;
      for (int k = 0; k < 3; ++k) {
        node_of_body.u[k] = static_cast<double>(sum.momentum[k]) * scale + a_.dt * a_.gravity[k];
      }
      at[count] = index;
      if constexpr (kMeets) {
        for (int axis = 0; axis < 3; ++axis) {
          int other[3] = {node[0], node[1], node[2]};
          ++other[axis];
          const double above = mass_at(sums, body, other);
          other[axis] -= 2;
          node_of_body.mass_per_dx[axis] = 0.5 * (above - mass_at(sums, body, other));
        }
      }
      ++count;
    }
    T largest(0);
    if constexpr (kMeets) {
      for (int k = 0; k < count; ++k) see(here[k].u, largest);
      if (count > 1) meet(here, count, a_.friction);
    }
    for (int k = 0; k < count; ++k) {
      see(here[k].u, largest);
      if (block.obstacle != 0) {
        contact(node, here[k].u);
        see(here[k].u, largest);
      }
      a_.velocity[at[k]] = {{T(here[k].u.x), T(here[k].u.y), T(here[k].u.z)}, T(0)};
    }
    raise_together(&s_.speed, bits_of(largest));
  }

  PHYSMAS_DEVICE static void see(const Vec3d& u, T& largest) {
    for (int k = 0; k < 3; ++k) largest = at_least(absolute(T(u[k])), largest);
  }

  PHYSMAS_DEVICE void contact(const int* node, Vec3d& u) const {
    const Vec3d x = {node[0] * a_.dx, node[1] * a_.dx, node[2] * a_.dx};
    for (int c = 0; c < a_.collider_count; ++c) u = apply_contact(a_.colliders[c], locate(a_.colliders[c], x), u);
    for (int axis = 0; axis < 3; ++axis) {
      if (node[axis] <= a_.wall_cells) u[axis] = at_least(u[axis], 0.0);
      if (node[axis] >= a_.n - a_.wall_cells) u[axis] = at_most(u[axis], 0.0);
    }
  }

  const Arguments& a_;
  Shared& s_;
  const int thread_;
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
