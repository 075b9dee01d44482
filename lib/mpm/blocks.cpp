#include "mpm/blocks.h"

#include <algorithm>

namespace physmas::mpm {

BlockMap::BlockMap(int nodes, int lanes) : table_((nodes + kBlock - 1) / kBlock + 2), lanes_(lanes) {
  slot_of_block_.assign(grid_block_count(), -1);
}

void BlockMap::sort(const std::vector<int>& base) {
  const int count = static_cast<int>(base.size() / 3);
  // Active blocks in ascending id.
  std::vector<int> ids;
  bucket_.resize(count);
  order_.resize(count);
  for (int i = 0; i < count; ++i) {
    const int id = block_id(base[3 * i] / kBlock, base[3 * i + 1] / kBlock, base[3 * i + 2] / kBlock);
    bucket_[i] = id;
    if (slot_of_block_[id] < 0) {
      slot_of_block_[id] = 0;
      ids.push_back(id);
    }
  }
  std::sort(ids.begin(), ids.end());
  particle_blocks.assign(ids.size(), {});
  for (size_t b = 0; b < ids.size(); ++b) {
    slot_of_block_[ids[b]] = static_cast<int>(b);
    particle_blocks[b].id = ids[b];
  }
  for (int i = 0; i < count; ++i) {
    bucket_[i] = slot_of_block_[bucket_[i]];
    ++particle_blocks[bucket_[i]].count;
  }
  for (const int id : ids) slot_of_block_[id] = -1;

  // Stable: particles of a block keep their previous order inside each cell.
  std::vector<int> next(ids.size());
  int slots = 0, particles = 0;
  for (size_t b = 0; b < ids.size(); ++b) {
    particle_blocks[b].begin = slots;
    next[b] = particles;
    particles += particle_blocks[b].count;
    slots += (particle_blocks[b].count + lanes_ - 1) / lanes_ * lanes_;
  }
  for (int i = 0; i < count; ++i) order_[next[bucket_[i]]++] = i;

  source.assign(slots, -1);
  int first = 0;
  for (ParticleBlock& block : particle_blocks) {
    int cell_begin[kBlockNodes + 1] = {};
    const auto cell_of = [&](int i) {
      return ((base[3 * i] % kBlock) * kBlock + base[3 * i + 1] % kBlock) * kBlock + base[3 * i + 2] % kBlock;
    };
    for (int axis = 0; axis < 3; ++axis) {
      block.position[axis] = base[3 * order_[first] + axis] / kBlock;
      block.low[axis] = kArena, block.high[axis] = -1;
    }
    for (int k = first; k < first + block.count; ++k) {
      const int i = order_[k];
      ++cell_begin[cell_of(i) + 1];
      for (int axis = 0; axis < 3; ++axis) {
        // Arena node of the base is (base % 4) + 1; one cell of drift; two further nodes of the stencil.
        const int node = base[3 * i + axis] % kBlock;
        block.low[axis] = std::min(block.low[axis], node);
        block.high[axis] = std::max(block.high[axis], node + 4);
      }
    }
    for (int c = 0; c < kBlockNodes; ++c) cell_begin[c + 1] += cell_begin[c];
    for (int k = first; k < first + block.count; ++k) {
      source[block.begin + cell_begin[cell_of(order_[k])]++] = order_[k];
    }
    first += block.count;
  }
  collect_grid_blocks();
}

void BlockMap::collect_grid_blocks() {
  struct Reach {
    int id, position[3];
    ArenaPart part;
  };
  std::vector<Reach> reached;
  for (size_t b = 0; b < particle_blocks.size(); ++b) {
    const ParticleBlock& block = particle_blocks[b];
    for (int code = 0; code < 27; ++code) {
      const int step[3] = {code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1};
      Reach r{};
      r.part.arena = static_cast<int>(b);
      bool empty = false;
      for (int axis = 0; axis < 3; ++axis) {
        // Grid node 4 (p + step) + k is arena node 4 step + k + 1.
        const int offset = kBlock * step[axis] + 1;
        const int low = std::max(0, block.low[axis] - offset);
        const int high = std::min(kBlock - 1, block.high[axis] - offset);
        empty = empty || low > high;
        r.part.offset[axis] = static_cast<std::int8_t>(offset);
        r.part.low[axis] = static_cast<std::int8_t>(low);
        r.part.high[axis] = static_cast<std::int8_t>(high);
        r.position[axis] = block.position[axis] + step[axis];
      }
      if (empty) continue;
      r.id = block_id(r.position[0], r.position[1], r.position[2]);
      reached.push_back(r);
    }
  }
  std::sort(reached.begin(), reached.end(),
            [](const Reach& a, const Reach& b) { return a.id != b.id ? a.id < b.id : a.part.arena < b.part.arena; });
  grid_blocks.clear();
  parts.clear();
  for (const Reach& r : reached) {
    if (grid_blocks.empty() || grid_blocks.back().id != r.id) {
      const int begin = static_cast<int>(parts.size());
      grid_blocks.push_back({r.id, {r.position[0], r.position[1], r.position[2]}, begin, begin});
    }
    parts.push_back(r.part);
    grid_blocks.back().parts_end = static_cast<int>(parts.size());
  }
}

}  // namespace physmas::mpm
