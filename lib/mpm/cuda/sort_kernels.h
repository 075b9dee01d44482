// The sort of particles by home (layout.h), and inside of a home by law, then so that neighbouring threads work in
// different cells, and by position: in which order particles lay before makes no difference, unless two of one cell lie
// within 2^-18 of it; those go by their number.
#ifndef PHYSMAS_MPM_CUDA_SORT_KERNELS_H
#define PHYSMAS_MPM_CUDA_SORT_KERNELS_H

#include "mpm/cuda/layout.h"
#include "mpm/math/mat3.h"

namespace physmas::mpm::PHYSMAS_GPU {

template <class T>
struct SortArguments {
  ParticleArrays<T> particles, sorted;
  int channels;
  BlockTable table;
  const RowMaterial<T>* rows;
  int* counts;        // per home
  const int* starts;  // per home
  // Per particle: its home, its place among those of its home as they came, and the key that it is sorted by.
  int *home, *place;
  unsigned long long* key;
  // Per place in the list of the homes' particles, as they came.
  int *listed, *listed_id;
  unsigned long long *listed_key, *order;
};

// A thread for each particle.
template <class T>
class PerParticle {
 public:
  using Arguments = SortArguments<T>;
  struct Shared {
    int unused;
  };
  static constexpr int kThreads = 256, kResident = 1, kPhases = 1, kFinalPhases = 0;
  PHYSMAS_DEVICE PerParticle(const Arguments& arguments, Shared&, int thread) : a_(arguments), thread_(thread) {}
  PHYSMAS_DEVICE int items() const { return (a_.particles.count + kThreads - 1) / kThreads; }

 protected:
  const Arguments& a_;
  const int thread_;
};

// Puts every particle into the block that it is in now.
template <class T>
class FindHomes : public PerParticle<T> {
 public:
  using PerParticle<T>::PerParticle;
  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    const SortArguments<T>& a = this->a_;
    const int p = item * this->kThreads + this->thread_;
    if (p >= a.particles.count) return;
    int block = a.particles.channel_of_ints(kBlock)[p], cell = 0;
    unsigned long long inside = 0;
    const int stride[3] = {a.table.side * a.table.side, a.table.side, 1};
    for (int axis = 0; axis < 3; ++axis) {
      T& x = a.particles.channel(Channels::kPosition + axis)[p];
      const T base = at_most(at_least(round_down(x - T(0.5)), T(-1)), T(kCells));
      int at = static_cast<int>(base);
      inside = inside << 18 | within(x - T(0.5) - base);
      if (at < 0) {
        block -= stride[axis], at += kCells, x += T(kCells);
      } else if (at >= kCells) {
        block += stride[axis], at -= kCells, x -= T(kCells);
      }
      cell = cell * kCells + at;
    }
    const RowMaterial<T>& row = a.rows[a.particles.channel_of_ints(kRow)[p]];
    const int home = row.body * a.table.count() + block;
    a.particles.channel_of_ints(kBlock)[p] = block;
    a.home[p] = home;
    a.place[p] = add(a.counts + home, 1);
    a.key[p] = static_cast<unsigned long long>(row.branch * kBlockNodes + cell) << 54 | inside;
  }

 private:
  // 18 bits of a number from 0 to 1.
  PHYSMAS_DEVICE static unsigned long long within(const T& share) {
    const T scaled = at_most(at_least(share, T(0)) * T(1 << 18), T((1 << 18) - 1));
    return static_cast<unsigned long long>(static_cast<int>(scaled));
  }
};

template <class T>
class ListHomes : public PerParticle<T> {
 public:
  using PerParticle<T>::PerParticle;
  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    const SortArguments<T>& a = this->a_;
    const int p = item * this->kThreads + this->thread_;
    if (p >= a.particles.count) return;
    const int at = a.starts[a.home[p]] + a.place[p];
    a.listed[at] = p;
    a.listed_id[at] = a.particles.channel_of_ints(kId)[p];
    a.listed_key[at] = a.key[p];
  }
};

// What particles of one law and home are ordered by: first one of every cell, then the second of every cell, and so on.
template <class T>
class RankInCells : public PerParticle<T> {
 public:
  using PerParticle<T>::PerParticle;
  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    const SortArguments<T>& a = this->a_;
    const int at = item * this->kThreads + this->thread_;
    if (at >= a.particles.count) return;
    const int home = a.home[a.listed[at]], first = a.starts[home], end = first + a.counts[home];
    const unsigned long long key = a.listed_key[at], cell = key >> 54;
    const int id = a.listed_id[at];
    unsigned long long layer = 0;
    for (int q = first; q < end; ++q) {
      const unsigned long long other = a.listed_key[q];
      if (other >> 54 == cell && (other < key || (other == key && a.listed_id[q] < id))) ++layer;
    }
    a.order[at] = cell / kBlockNodes << 40 | layer << 6 | cell % kBlockNodes;
  }
};

template <class T>
class MoveSorted : public PerParticle<T> {
 public:
  using PerParticle<T>::PerParticle;
  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    const SortArguments<T>& a = this->a_;
    const int at = item * this->kThreads + this->thread_;
    if (at >= a.particles.count) return;
    const int p = a.listed[at], home = a.home[p], first = a.starts[home], end = first + a.counts[home];
    const unsigned long long order = a.order[at];
    int to = first;
    for (int q = first; q < end; ++q) to += a.order[q] < order ? 1 : 0;
    for (int c = 0; c < a.channels; ++c) a.sorted.channel(c)[to] = a.particles.channel(c)[p];
    for (int c = 0; c < kIntChannels; ++c) a.sorted.channel_of_ints(c)[to] = a.particles.channel_of_ints(c)[p];
  }
};

// Changes of the table of slots. A slot that is taken begins with sums of zero.
struct SlotArguments {
  const int* entry;  // [count] of the table
  const int* slot;   // [count] new, -1: none
  int count;
  int* slots;
  NodeSum* sums[2];
};
class ChangeSlots {
 public:
  using Arguments = SlotArguments;
  struct Shared {
    int unused;
  };
  static constexpr int kThreads = kBlockNodes, kResident = 1, kPhases = 1, kFinalPhases = 0;
  PHYSMAS_DEVICE ChangeSlots(const Arguments& arguments, Shared&, int thread) : a_(arguments), thread_(thread) {}
  PHYSMAS_DEVICE int items() const { return a_.count; }
  template <int kPhase>
  PHYSMAS_DEVICE void phase(int item) {
    const int slot = a_.slot[item];
    if (thread_ == 0) a_.slots[a_.entry[item]] = slot;
    if (slot < 0) return;
    for (int which = 0; which < 2; ++which) a_.sums[which][static_cast<size_t>(slot) * kBlockNodes + thread_] = {};
  }

 private:
  const Arguments& a_;
  const int thread_;
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
