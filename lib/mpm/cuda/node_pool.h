// Which blocks of nodes have memory on the device, and what particles come together to items: the host's part of a
// sort.
#ifndef PHYSMAS_MPM_CUDA_NODE_POOL_H
#define PHYSMAS_MPM_CUDA_NODE_POOL_H

#include <algorithm>
#include <vector>

#include "mpm/action/collider.h"
#include "mpm/cuda/device_array.h"
#include "mpm/cuda/sort_kernels.h"
#include "mpm/stepper_setup.h"

namespace physmas::mpm::PHYSMAS_GPU {

template <class T>
class NodePool {
  Queue& queue_;
  const Domain& domain_;
  const int bodies_;

 public:
  NodePool(Queue& queue, const Domain& domain, int bodies) : queue_(queue), domain_(domain), bodies_(bodies) {
    table.side = (domain.n + 1 + kCells - 1) / kCells + 2;
    slot_of_.assign(static_cast<size_t>(bodies) * table.count(), -1);
    needed_.assign(slot_of_.size(), 0);
    active_since_.assign(table.count(), 0);
    slots.upload(slot_of_);
  }

  BlockTable table;
  DeviceArray<int> slots{queue_};
  DeviceArray<NodeSum> sums[2] = {DeviceArray<NodeSum>(queue_), DeviceArray<NodeSum>(queue_)};
  DeviceArray<NodeVelocity<T>> velocity{queue_};
  DeviceArray<Item> items{queue_};
  DeviceArray<ActiveBlock> blocks{queue_};
  DeviceArray<int> counts{queue_};  // of items and of blocks

  int homes() const { return bodies_ * table.count(); }
  int block_count() const { return static_cast<int>(active_.size()); }
  int item_count() const { return static_cast<int>(items_.size()); }
  size_t bytes() const {
    return static_cast<size_t>(used_) * kBlockNodes * (2 * sizeof(NodeSum) + sizeof(NodeVelocity<T>));
  }

  // particles: per home. Fills starts, the number of particles in the homes before; items and blocks follow, and every
  // block that is new has sums of zero. Velocities of blocks that stay are kept.
  void arrange(const std::vector<int>& particles, std::vector<int>& starts) {
    ++round_;
    items_.clear();
    active_.clear();
    starts.resize(particles.size());
    int first = 0;
    std::vector<int> wanted;
    for (int home = 0; home < homes(); ++home) {
      starts[home] = first;
      const int count = particles[home];
      if (count == 0) continue;
      add_items(home, first, count);
      first += count;
      for (int k = 0; k < kNeighbours; ++k) {
        const int entry = home / table.count() * table.count() + table.neighbour(home % table.count(), k);
        if (needed_[entry] == round_) continue;
        needed_[entry] = round_;
        wanted.push_back(entry);
      }
    }
    change_slots(wanted);
    std::sort(active_.begin(), active_.end(),
              [](const ActiveBlock& a, const ActiveBlock& b) { return a.block < b.block; });
    items.upload(items_);
    blocks.upload(active_);
    counts_ = {item_count(), block_count()};
    counts.upload(counts_);
  }

  // All sums to zero.
  void clear() {
    for (auto& array : sums) array.zero();
  }

 private:
  void add_items(int home, int first, int count) {
    Item item{};
    item.body = home / table.count();
    item.block = home % table.count();
    table.locate(item.block, item.position);
    // Of about the same size.
    const int parts = (count + kMostInItem_ - 1) / kMostInItem_;
    for (int k = 0; k < parts; ++k) {
      const int from = static_cast<int>(static_cast<long long>(count) * k / parts);
      const int to = static_cast<int>(static_cast<long long>(count) * (k + 1) / parts);
      item.first = first + from, item.count = to - from;
      items_.push_back(item);
    }
  }

  void change_slots(const std::vector<int>& wanted) {
    entry_.clear();
    slot_.clear();
    const auto change = [&](int entry, int slot) {
      slot_of_[entry] = slot;
      entry_.push_back(entry);
      slot_.push_back(slot);
    };
    for (const int entry : held_) {
      if (needed_[entry] == round_) continue;
      free_.push_back(slot_of_[entry]);
      --used_;
      change(entry, -1);
    }
    for (const int entry : wanted) {
      const int block = entry % table.count();
      if (active_since_[block] != round_) {
        active_since_[block] = round_;
        int first[3];
        table.locate(block, first);
        for (int& node : first) node *= kCells;
        active_.push_back({block, near_obstacle(domain_, first, kCells) ? 1 : 0});
      }
      if (slot_of_[entry] >= 0) continue;
      if (free_.empty()) {
        change(entry, made_++);
      } else {
        change(entry, free_.back());
        free_.pop_back();
      }
      ++used_;
    }
    held_ = wanted;
    if (static_cast<size_t>(made_) * kBlockNodes > velocity.size()) {
      const size_t now = velocity.size(), size = static_cast<size_t>(made_ + made_ / 4) * kBlockNodes;
      for (auto& array : sums) array.resize(size, now);
      velocity.resize(size, now);
    }
    if (entry_.empty()) return;
    device_entry_.upload(entry_);
    device_slot_.upload(slot_);
    const int count = static_cast<int>(entry_.size());
    queue_.template launch<ChangeSlots>(
        count, {device_entry_.data(), device_slot_.data(), count, slots.data(), {sums[0].data(), sums[1].data()}});
    queue_.wait();  // what was copied from is used again
  }

  static constexpr int kMostInItem_ = sizeof(T) == 4 ? 256 : 128;

  std::vector<Item> items_;
  std::vector<ActiveBlock> active_;
  std::vector<int> counts_;
  std::vector<int> slot_of_;                     // the host's copy of the table
  std::vector<int> held_;                        // entries with a slot
  std::vector<int> free_;                        // slots that nobody holds
  std::vector<unsigned> needed_, active_since_;  // per entry, per block: the round
  unsigned round_ = 0;
  int made_ = 0, used_ = 0;
  std::vector<int> entry_, slot_;
  DeviceArray<int> device_entry_{queue_}, device_slot_{queue_};
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
