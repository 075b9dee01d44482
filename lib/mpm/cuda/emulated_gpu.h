// gpu.h where there is no GPU: blocks and threads one after the other. It tests what kernels compute, every index and
// every launch; of races it finds those that show in another order of threads, and of speed it says nothing.
#ifndef PHYSMAS_MPM_CUDA_EMULATED_GPU_H
#define PHYSMAS_MPM_CUDA_EMULATED_GPU_H

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <vector>

#include "base/error.h"
#include "mpm/math/real.h"

#define PHYSMAS_GPU emulated_gpu
#define PHYSMAS_DEVICE inline

namespace physmas::mpm::PHYSMAS_GPU {

// In which order blocks and threads are taken.
enum class Order { ascending, descending, scattered };
inline Order order_of_threads = Order::ascending;

inline int taken(int round, int count) {
  if (order_of_threads == Order::ascending) return round;
  if (order_of_threads == Order::descending) return count - 1 - round;
  int stride = count / 2 + 1;  // next to it is one without a common factor
  const auto common = [count](int a) {
    int b = count;
    while (b != 0) {
      const int rest = a % b;
      a = b;
      b = rest;
    }
    return a;
  };
  while (common(stride) != 1) ++stride;
  return static_cast<int>(static_cast<long long>(round) * stride % count);
}

// Sums wrap around, as the device's do.
inline int add(int* to, int value) {
  const int before = *to;
  *to = static_cast<int>(static_cast<unsigned>(before) + static_cast<unsigned>(value));
  return before;
}
inline void add_global(long long* to, long long value) {
  *to = static_cast<long long>(static_cast<unsigned long long>(*to) + static_cast<unsigned long long>(value));
}
inline void raise(unsigned* to, unsigned value) {
  if (value > *to) *to = value;
}
inline void raise(unsigned long long* to, unsigned long long value) {
  if (value > *to) *to = value;
}
template <class Bits>
void raise_together(Bits* to, Bits value) {
  raise(to, value);
}
inline void set_bits(int* to, int bits) {
  *to |= bits;
}
inline unsigned bits_of(float x) {
  unsigned bits;
  std::memcpy(&bits, &x, sizeof(bits));
  return bits;
}
inline unsigned long long bits_of(double x) {
  unsigned long long bits;
  std::memcpy(&bits, &x, sizeof(bits));
  return bits;
}
inline float number_of(unsigned bits) {
  float x;
  std::memcpy(&x, &bits, sizeof(x));
  return x;
}
inline double number_of(unsigned long long bits) {
  double x;
  std::memcpy(&x, &bits, sizeof(x));
  return x;
}
template <class Int, class T>
Int nearest_of(T x) {
  if (!(x == x)) return 0;
  if (x >= -static_cast<T>(std::numeric_limits<Int>::min())) return std::numeric_limits<Int>::max();
  if (x <= static_cast<T>(std::numeric_limits<Int>::min())) return std::numeric_limits<Int>::min();
  return static_cast<Int>(std::rint(x));
}
inline int nearest_int(float x) {
  return nearest_of<int>(x);
}
inline long long nearest_long(double x) {
  return nearest_of<long long>(x);
}
template <class T>
T fresh(const T* from) {
  return *from;
}

template <int kPhase, class Kernel>
void run_phases(std::vector<Kernel>& threads, int item) {
  if constexpr (kPhase < Kernel::kPhases) {
    for (int t = 0; t < Kernel::kThreads; ++t) threads[taken(t, Kernel::kThreads)].template phase<kPhase>(item);
    run_phases<kPhase + 1>(threads, item);
  }
}
template <int kPhase, class Kernel>
void run_final_phases(std::vector<Kernel>& threads) {
  if constexpr (kPhase < Kernel::kFinalPhases) {
    for (int t = 0; t < Kernel::kThreads; ++t) threads[taken(t, Kernel::kThreads)].template final_phase<kPhase>();
    run_final_phases<kPhase + 1>(threads);
  }
}

class Queue {
 public:
  static constexpr size_t kAlignment = 256;  // as the device's own
  static void* allocate(size_t bytes) {
    void* memory = nullptr;
    if (posix_memalign(&memory, kAlignment, bytes) != 0) throw std::bad_alloc();
    std::memset(memory, 0x7b, bytes);
    return memory;
  }
  static void release(void* memory) { std::free(memory); }
  void copy_in(void* to, const void* from, size_t bytes) { copy(to, from, bytes); }
  void copy_out(void* to, const void* from, size_t bytes) { copy(to, from, bytes); }
  void copy_on(void* to, const void* from, size_t bytes) { copy(to, from, bytes); }
  void zero(void* memory, size_t bytes) {
    if (bytes > 0) std::memset(memory, 0, bytes);
  }
  void wait() {}

  template <class Kernel>
  void launch(int blocks, const typename Kernel::Arguments& arguments) {
    static_assert(Kernel::kThreads <= 1024 && sizeof(typename Kernel::Shared) <= 48 * 1024 - 16);
    static_assert(sizeof(typename Kernel::Arguments) <= 4096);
    if (blocks < 1) throw internal_error("a launch of no blocks");
    for (int b = 0; b < blocks; ++b) {
      const int block = taken(b, blocks);
      // Shared memory holds what the last block left there.
      const std::unique_ptr<typename Kernel::Shared> shared(new typename Kernel::Shared);
      std::memset(static_cast<void*>(shared.get()), 0x7b, sizeof(*shared));
      std::vector<Kernel> threads;
      threads.reserve(Kernel::kThreads);
      for (int t = 0; t < Kernel::kThreads; ++t) threads.emplace_back(arguments, *shared, t);
      const int items = threads[0].items();
      for (int item = block; item < items; item += blocks) run_phases<0>(threads, item);
      if constexpr (Kernel::kFinalPhases > 0) {
        if (add(threads[0].ticket(), 1) == blocks - 1) {
          run_final_phases<0>(threads);
          *threads[0].ticket() = 0;
        }
      }
    }
  }
  template <class Kernel>
  int fitting_blocks() const {
    return 3;  // so that blocks have several items each
  }

 private:
  static void copy(void* to, const void* from, size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
