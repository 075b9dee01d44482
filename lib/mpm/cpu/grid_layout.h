// How the nodes of the background grid lie in memory: four numbers per node, along z, then y, then x, with a ring
// of nodes around the grid that stencils of particles at its edge may name.
#ifndef PHYSMAS_MPM_CPU_GRID_LAYOUT_H
#define PHYSMAS_MPM_CPU_GRID_LAYOUT_H

#include <cstddef>

#include "mpm/cpu/blocks.h"

namespace physmas::mpm {

struct GridLayout {
  // nodes: per axis.
  explicit GridLayout(int nodes) {
    const int inner = (nodes + kBlock - 1) / kBlock * kBlock;
    // Lines along z of an odd number of blocks, and an odd number of them, spread over all sets of a cache.
    nodes_z_ = kBlock * ((inner + 2 * kBlock) / kBlock / 2 * 2 + 1);
    nodes_y_ = (inner + kBlock) / 2 * 2 + 1;
    planes_ = inner + kBlock;
  }
  // Numbers from a node to its neighbour along x, y and z.
  std::ptrdiff_t step_x() const { return std::ptrdiff_t{4} * nodes_y_ * nodes_z_; }
  std::ptrdiff_t step_y() const { return std::ptrdiff_t{4} * nodes_z_; }
  // First number of a node; node -1 and the three after the grid's last block exist. The first node of a block is
  // aligned to four nodes.
  size_t offset(int x, int y, int z) const {
    return 4 * ((static_cast<size_t>(x + 1) * nodes_y_ + (y + 1)) * nodes_z_ + (z + kBlock));
  }
  size_t numbers() const { return 4 * static_cast<size_t>(planes_) * nodes_y_ * nodes_z_; }

 private:
  int planes_, nodes_y_, nodes_z_;
};

}  // namespace physmas::mpm

#endif
