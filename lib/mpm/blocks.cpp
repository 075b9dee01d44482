#include "mpm/blocks.h"

#include <algorithm>

namespace physmas::mpm {

BlockMap::BlockMap(int nodes) : table_((nodes + kBlock - 1) / kBlock + 2) {
  index_of_id_.assign(grid_block_count(), -1);
}

void BlockMap::start(std::vector<int> ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  particle_blocks.assign(ids.size(), {});
  for (size_t b = 0; b < ids.size(); ++b) {
    index_of_id_[ids[b]] = static_cast<int>(b);
    ParticleBlock& block = particle_blocks[b];
    block.id = ids[b];
    for (int axis = 0; axis < 3; ++axis) {
      block.position[axis] = ids[b] / id_stride(axis) % table_ - 1;
    }
  }
}

void BlockMap::connect() {
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
