// Particles sorted by blocks of 4^3 cells, and which grid blocks they reach.
//
// A particle belongs to the cell of its base node, the lowest of the 3 nodes per axis that its quadratic B-spline
// touches. Every particle block owns an arena of 8^3 nodes: its 4^3 cells, the two further nodes of the stencil, and
// one more cell on each side, so that particles may drift by up to one cell between two sorts.
#ifndef PHYSMAS_MPM_BLOCKS_H
#define PHYSMAS_MPM_BLOCKS_H

#include <cstdint>
#include <vector>

namespace physmas::mpm {

constexpr int kBlock = 4;  // nodes per axis of a grid block
constexpr int kArena = 8;  // nodes per axis of a particle block's arena
constexpr int kBlockNodes = kBlock * kBlock * kBlock;
constexpr int kArenaNodes = kArena * kArena * kArena;

// A block of cells with its particles. Arena node 0 is grid node 4 * position - 1.
struct ParticleBlock {
  int id;               // index into the table of grid blocks
  int position[3];      // block coordinates: grid node 4 * position is the block's first
  int begin;            // first slot, a multiple of the lane count
  int count;            // particles; slots up to the next multiple of the lane count are empty
  int low[3], high[3];  // arena nodes that its particles can reach until the next sort, inclusive
};

// What one arena adds to one grid block: the overlap of both.
struct ArenaPart {
  int arena;                    // index of the particle block
  std::int8_t offset[3];        // arena node = grid block node + offset
  std::int8_t low[3], high[3];  // grid block nodes, inclusive
};

// A block of grid nodes that particles can reach.
struct GridBlock {
  int id;
  int position[3];
  int parts_begin, parts_end;  // its range in `parts`, in the order of the particle blocks
};

class BlockMap {
 public:
  // nodes: grid nodes per axis; lanes: slots per particle group.
  BlockMap(int nodes, int lanes);

  // Sorts particles by (block, cell, previous order). base: [3 N] base nodes per particle, x y z; each in 1..nodes-4.
  // Afterwards `source` names for every slot the particle that it holds, -1 for an empty one.
  void sort(const std::vector<int>& base);

  int grid_block_count() const { return table_ * table_ * table_; }
  // One ring of blocks around the grid keeps neighbours of border blocks addressable.
  int block_id(int x, int y, int z) const { return ((x + 1) * table_ + (y + 1)) * table_ + (z + 1); }
  // Distance between the ids of blocks that are neighbours along an axis.
  int id_stride(int axis) const { return axis == 0 ? table_ * table_ : axis == 1 ? table_ : 1; }

  std::vector<int> source;
  std::vector<ParticleBlock> particle_blocks;  // ascending id
  std::vector<GridBlock> grid_blocks;          // ascending id
  std::vector<ArenaPart> parts;

 private:
  void collect_grid_blocks();

  int table_;
  int lanes_;
  std::vector<int> slot_of_block_;  // scratch: block id → index, -1 when not active
  std::vector<int> bucket_, order_;
};

}  // namespace physmas::mpm

#endif
