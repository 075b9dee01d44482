// What lies in the memory of the device, as host and kernels see it.
//
// Particles are sorted by home: a body and a block of 4³ cells, in which their base nodes lie. The threads of one item
// take particles of one home. They see the 8³ nodes around it, one cell more than the block's own on each side, so that
// particles may drift by up to a cell between two sorts. Nodes come in blocks of 4³ too, and only those that some
// particle may reach have memory: a table gives a block's slot in the pool, per body.
#ifndef PHYSMAS_MPM_CUDA_LAYOUT_H
#define PHYSMAS_MPM_CUDA_LAYOUT_H

#include <cstddef>

#include "mpm/action/control.h"
#include "mpm/cuda/gpu.h"
#include "mpm/domain.h"
#include "mpm/material/material.h"

namespace physmas::mpm::PHYSMAS_GPU {

constexpr int kCells = 4;  // of a block, per axis; and its nodes
constexpr int kBlockNodes = kCells * kCells * kCells;
constexpr int kTile = 8;  // nodes around a block, per axis: -1 to 6
constexpr int kTileNodes = kTile * kTile * kTile;
constexpr int kNeighbours = 27;
// Particles stay so many cells away from the edge of the grid: every node of a stencil exists.
constexpr double kEdgeCells = 2;
// A sort is due before particles could drift this far [cells].
constexpr double kDriftLimit = 0.999;

// Blocks are numbered with a ring around the grid, so that every neighbour has a number.
struct BlockTable {
  int side = 0;  // blocks per axis, the ring included

  PHYSMAS_HOST_DEVICE int count() const { return side * side * side; }
  PHYSMAS_HOST_DEVICE int id(int x, int y, int z) const { return ((x + 1) * side + (y + 1)) * side + (z + 1); }
  PHYSMAS_HOST_DEVICE void locate(int id, int* position) const {
    position[0] = id / (side * side) - 1;
    position[1] = id / side % side - 1;
    position[2] = id % side - 1;
  }
  // Neighbour k of 27, 13 being the block itself.
  PHYSMAS_HOST_DEVICE int neighbour(int id, int k) const {
    return id + ((k / 9 - 1) * side + (k / 3 % 3 - 1)) * side + (k % 3 - 1);
  }
};

// Some particles of one home.
struct Item {
  int block, body;
  int first, count;  // particles
  int position[3];   // of the block: grid node 4 * position is its first
  int unused;
};

// A block of nodes that particles of some body can reach.
struct ActiveBlock {
  int block;
  int obstacle;  // a wall or a collider may touch it
};

// The sums that particles leave at a node, in whole numbers of units, so that their order does not matter.
struct alignas(32) NodeSum {
  long long momentum[3], mass;
};
template <class T>
struct alignas(4 * sizeof(T)) NodeVelocity {
  T u[3], unused;  // m/s
};

// Bits of a frame of a cell per substep.
constexpr int kFrameBits = 22;
// The units of sums are powers of two, so small that nothing is lost and so large that nothing overflows.
struct SumUnits {
  int momentum = 0, mass = 0, velocity = 0;       // units per kg m/s, kg and m/s (of a frame), as powers of two
  double momentum_units = 1, mass_units = 1;      // the same
  double momentum_of_unit = 1, mass_of_unit = 1;  // and the other way round
  double velocity_units = 1, velocity_of_unit = 1;
  double most_momentum = 0;  // what one particle may bring to a node [kg m/s]
};

// Numbers of a particle, one array per number.
struct Channels {
  static constexpr int kPosition = 0;     // [cells] from the block's first node
  static constexpr int kDeformation = 3;  // row-major
  static constexpr int kVolume = 12;      // [m^3]
  static constexpr int kVelocity = 13;    // [m/s], after load and after the last pass of an interval
  static constexpr int kGradient = 16;    // [1/s], likewise
  static constexpr int kFixed = 25;
  int strength = -1;    // [Pa], when some row is plasticine
  int elasticity = -1;  // mu, lambda [Pa], density, when particles have their own
  int total_F = -1;     // when tracked
  int count = kFixed;
};
// And whole ones.
enum IntChannel { kId, kRow, kControl, kBlock, kIntChannels };

template <class T>
struct ParticleArrays {
  T* numbers = nullptr;
  int* ints = nullptr;
  size_t stride = 0;  // entries per array
  int count = 0;

  PHYSMAS_HOST_DEVICE T* channel(int c) const { return numbers + static_cast<size_t>(c) * stride; }
  PHYSMAS_HOST_DEVICE int* channel_of_ints(int c) const { return ints + static_cast<size_t>(c) * stride; }
};

// What a row is made of.
template <class T>
struct RowMaterial {
  MaterialParameters<T> parameters;
  int branch, body;
};

enum Unbearable : int { kInfinite = 1, kOverflow = 2 };
enum Fault : int { kNoFault, kNotFinite, kTooFast, kTooMuchEnergy };

// One substep of a chunk, which the host prepares and reads afterwards. Kernels decide for themselves whether they may
// run, so that the host need not look in between.
struct StepRecord {
  // From the host.
  int controls;             // of this substep: which row of the table of controls, -1: all idle
  int sums;                 // which of the two arrays holds the sums of this substep
  double enforced, raised;  // m/s: how fast actions may move a particle besides the grid
  // 1: the grid may be updated; the particles may be advanced; they were.
  int grid_due, particles_due, done;
  int fault;
  int not_finite, unbearable, clamped;
  int unused;
  unsigned long long node_speed, particle_speed;  // bits of doubles: m/s of a component; squared
  double drift, next_drift;                       // cells since the sort, and in this substep, at most
  double kinetic, work;                           // J; work of controls since the interval began
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
