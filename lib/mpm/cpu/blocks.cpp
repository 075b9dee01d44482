#include "mpm/cpu/blocks.h"

#include <algorithm>

namespace physmas::mpm {

namespace {

// With fewer, threads wait for one another's blocks for longer than they save.
constexpr int kBlocksPerThread = 24;

int color_of(const ParticleBlock& block) {
  return 2 * (block.position[0] % 2) + block.position[1] % 2;
}

bool in_one_run(const ParticleBlock& a, const ParticleBlock& b) {
  return a.position[0] == b.position[0] && a.position[1] == b.position[1];
}

}  // namespace

BlockMap::BlockMap(int nodes) : table_((nodes + kBlock - 1) / kBlock + 2) {
  index_of_id_.assign(grid_block_count(), -1);
  reached_.assign(grid_block_count(), -1);
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

void BlockMap::connect(int threads) {
  const int count = static_cast<int>(particle_blocks.size());
  long long slots = 0, sum = 0;
  for (const ParticleBlock& block : particle_blocks) slots += block.slots;
  order.clear();
  run_bounds.assign(1, 0);
  thread_bounds.assign(1, 0);
  const int ranges = std::max(1, std::min(threads, count / kBlocksPerThread));
  const auto end_run = [&] {
    if (static_cast<int>(order.size()) > run_bounds.back()) run_bounds.push_back(static_cast<int>(order.size()));
  };
  for (int t = 0, begin = 0; t < threads; ++t) {
    int end = begin;
    while (end < count && (t + 1 >= ranges || sum * ranges < slots * (t + 1) ||
                           (end > begin && in_one_run(particle_blocks[end - 1], particle_blocks[end])))) {
      sum += particle_blocks[end++].slots;
    }
    for (int color = 0; color < 4; ++color) {
      for (int b = begin; b < end; ++b) {
        if (color_of(particle_blocks[b]) != color) continue;
        if (!order.empty() && !in_one_run(particle_blocks[order.back()], particle_blocks[b])) end_run();
        order.push_back(b);
      }
      end_run();
    }
    thread_bounds.push_back(static_cast<int>(run_bounds.size()) - 1);
    begin = end;
  }
  const int runs = static_cast<int>(run_bounds.size()) - 1;
  std::vector<int> run_of(count);
  for (int run = 0; run < runs; ++run) {
    for (int k = run_bounds[run]; k < run_bounds[run + 1]; ++k) run_of[order[k]] = run;
  }
  waits_for.resize(runs);
  for (int run = 0; run < runs; ++run) {
    std::vector<int>& before = waits_for[run];
    before.clear();
    for (int k = run_bounds[run]; k < run_bounds[run + 1]; ++k) {
      const ParticleBlock& block = particle_blocks[order[k]];
      for (int code = 0; code < 27; ++code) {
        const int id = block.id + (code / 9 - 1) * id_stride(0) + (code / 3 % 3 - 1) * id_stride(1) + code % 3 - 1;
        const int other = index_of_id_[id];
        if (other < 0 || other >= count || particle_blocks[other].id != id) continue;
        if (color_of(particle_blocks[other]) < color_of(block)) before.push_back(run_of[other]);
      }
    }
    std::sort(before.begin(), before.end());
    before.erase(std::unique(before.begin(), before.end()), before.end());
  }
  grid_blocks.clear();
  for (const ParticleBlock& block : particle_blocks) {
    for (int code = 0; code < 27; ++code) {
      const int step[3] = {code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1};
      bool empty = false;
      GridBlock reached{block.id, {}, block.bodies};
      for (int axis = 0; axis < 3; ++axis) {
        empty = empty || block.high[axis] < kBlock * step[axis] || block.low[axis] >= kBlock * (step[axis] + 1);
        reached.position[axis] = block.position[axis] + step[axis];
        reached.id += step[axis] * id_stride(axis);
      }
      if (empty) continue;
      if (reached_[reached.id] >= 0) {
        grid_blocks[reached_[reached.id]].bodies |= block.bodies;
        continue;
      }
      reached_[reached.id] = static_cast<int>(grid_blocks.size());
      grid_blocks.push_back(reached);
    }
  }
  for (const GridBlock& block : grid_blocks) reached_[block.id] = -1;
  std::sort(grid_blocks.begin(), grid_blocks.end(), [](const GridBlock& a, const GridBlock& b) { return a.id < b.id; });
}

}  // namespace physmas::mpm
