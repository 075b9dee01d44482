// Blocks of 4^3 cells with their particles, and which blocks of grid nodes they reach.
//
// A particle belongs to the cell of its base node, the lowest of the 3 nodes per axis that its quadratic B-spline
// touches. A block's particles reach its 4^3 cells, the two further nodes of the stencil, and one more cell on each
// side, since particles may drift by up to one cell between two sorts: nodes -1 to 6 of its own, so that blocks whose
// distance is even along x and y never meet unless they have both in common.
#ifndef PHYSMAS_MPM_CPU_BLOCKS_H
#define PHYSMAS_MPM_CPU_BLOCKS_H

#include <cstdint>
#include <vector>

namespace physmas::mpm {

constexpr int kBlock = 4;  // nodes per axis of a block
constexpr int kBlockNodes = kBlock * kBlock * kBlock;

// A block of cells with its particles.
struct ParticleBlock {
  int id = 0;            // index into the table of grid blocks
  int position[3] = {};  // block coordinates: grid node 4 * position is the block's first
  int first = 0;         // first of its particles in the order of the last sort
  int count = 0;         // particles
  int begin = 0;         // first slot, a multiple of the lane count
  int slots = 0;         // slots that belong to it, a multiple of the lane count
  int loose = 0;         // registers at its beginning whose particles go to the grid one by one
  int strayed = 0;       // by how many particles its columns have become poorer since the last sort
  unsigned bodies = 0;   // a bit for each body that has particles in it
  // Nodes from the block's first, inclusive, that its particles can reach until the next sort.
  std::int8_t low[3] = {}, high[3] = {};
};

// A block of grid nodes that particles can reach.
struct GridBlock {
  int id;
  int position[3];
  unsigned bodies;  // a bit for each body whose particles can
};

class BlockMap {
 public:
  // nodes: grid nodes per axis.
  explicit BlockMap(int nodes);

  int grid_block_count() const { return table_ * table_ * table_; }
  // One ring of blocks around the grid keeps neighbours of border blocks addressable.
  int block_id(int x, int y, int z) const { return ((x + 1) * table_ + (y + 1)) * table_ + (z + 1); }
  // Distance between the ids of blocks that are neighbours along an axis.
  int id_stride(int axis) const { return axis == 0 ? table_ * table_ : axis == 1 ? table_ : 1; }

  // Starts a new set of particle blocks from the ids that hold particles, in any order, repeated or not. Counts and
  // reaches are left for the caller to fill in.
  void start(std::vector<int> ids);
  // Index of the particle block with this id, which must be one of the set.
  int index_of(int id) const { return index_of_id_[id]; }
  // Whether several threads have particles, after connect().
  bool shared() const { return thread_bounds[1] != thread_bounds.back(); }
  // Once every particle block knows its reach: which grid blocks there are, and an order for so many threads.
  void connect(int threads);

  std::vector<ParticleBlock> particle_blocks;  // ascending id
  std::vector<GridBlock> grid_blocks;          // ascending id
  // All particle blocks in runs along z, of which a block shares half of its nodes with the next; the runs in a range
  // for every thread, of about as many particles, or in the first one where there are too few to share; in a range by
  // one of four colours and then by id. Runs of one colour share no node; neighbours of lower colours, which add to
  // nodes first, are in waits_for.
  std::vector<int> order;                   // blocks
  std::vector<int> run_bounds;              // run r is order[run_bounds[r]] to order[run_bounds[r + 1] - 1]
  std::vector<int> thread_bounds;           // of the threads' runs
  std::vector<std::vector<int>> waits_for;  // per run: runs

 private:
  int table_;
  std::vector<int> index_of_id_;  // valid for the present blocks only
  std::vector<int> reached_;      // per id: its index while grid_blocks is made; -1 between calls
};

}  // namespace physmas::mpm

#endif
