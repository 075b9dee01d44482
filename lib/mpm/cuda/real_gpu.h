// gpu.h where there is a GPU.
#ifndef PHYSMAS_MPM_CUDA_REAL_GPU_H
#define PHYSMAS_MPM_CUDA_REAL_GPU_H

#include <cuda_runtime.h>

#include <cstring>
#include <string>

#include "base/error.h"
#include "mpm/math/real.h"

// Everything that exists in both worlds is in a namespace of its world.
#define PHYSMAS_GPU real_gpu
#define PHYSMAS_DEVICE __device__ __forceinline__

namespace physmas::mpm::PHYSMAS_GPU {

// ---- On the device.

PHYSMAS_DEVICE int add(int* to, int value) {
  return atomicAdd(to, value);
}
// In global memory. Where the compiler has lost the address space of a pointer, atomicAdd tests for shared memory
// first.
PHYSMAS_DEVICE void add_global(long long* to, long long value) {
  asm volatile("red.global.add.u64 [%0], %1;" ::"l"(to), "l"(value) : "memory");
}
PHYSMAS_DEVICE void raise(unsigned* to, unsigned value) {
  atomicMax(to, value);
}
PHYSMAS_DEVICE void raise(unsigned long long* to, unsigned long long value) {
  atomicMax(to, value);
}
// In shared memory, by all threads of a block at once.
template <class Bits>
PHYSMAS_DEVICE void raise_together(Bits* to, Bits value) {
  for (int distance = 16; distance > 0; distance /= 2) {
    const Bits other = __shfl_xor_sync(0xffffffffu, value, distance);
    value = other > value ? other : value;
  }
  if (threadIdx.x % 32 == 0) atomicMax(to, value);
}
PHYSMAS_DEVICE void set_bits(int* to, int bits) {
  atomicOr(to, bits);
}
PHYSMAS_DEVICE unsigned bits_of(float x) {
  return __float_as_uint(x);
}
PHYSMAS_DEVICE unsigned long long bits_of(double x) {
  return static_cast<unsigned long long>(__double_as_longlong(x));
}
PHYSMAS_DEVICE float number_of(unsigned bits) {
  return __uint_as_float(bits);
}
PHYSMAS_DEVICE double number_of(unsigned long long bits) {
  return __longlong_as_double(static_cast<long long>(bits));
}
// To the nearest integer, the largest or smallest one where there is none.
PHYSMAS_DEVICE int nearest_int(float x) {
  return __float2int_rn(x);
}
PHYSMAS_DEVICE long long nearest_long(double x) {
  return __double2ll_rn(x);
}
// Past a cache that may hold what was there before another block wrote.
template <class T>
PHYSMAS_DEVICE T fresh(const T* from) {
  return __ldcg(from);
}

// ---- Launching.

template <int kPhase, class Kernel>
PHYSMAS_DEVICE void run_phases(Kernel& kernel, int item) {
  if constexpr (kPhase < Kernel::kPhases) {
    kernel.template phase<kPhase>(item);
    __syncthreads();
    run_phases<kPhase + 1>(kernel, item);
  }
}
template <int kPhase, class Kernel>
PHYSMAS_DEVICE void run_final_phases(Kernel& kernel) {
  if constexpr (kPhase < Kernel::kFinalPhases) {
    kernel.template final_phase<kPhase>();
    __syncthreads();
    run_final_phases<kPhase + 1>(kernel);
  }
}

template <class Kernel>
__global__ void __launch_bounds__(Kernel::kThreads, Kernel::kResident)
    run_kernel(const __grid_constant__ typename Kernel::Arguments arguments) {
  __shared__ typename Kernel::Shared shared;
  Kernel kernel(arguments, shared, static_cast<int>(threadIdx.x));
  const int items = kernel.items();
  for (int item = static_cast<int>(blockIdx.x); item < items; item += static_cast<int>(gridDim.x)) {
    run_phases<0>(kernel, item);
  }
  if constexpr (Kernel::kFinalPhases > 0) {
    __shared__ bool last;
    if (threadIdx.x == 0) {
      __threadfence();
      last = atomicAdd(kernel.ticket(), 1) == static_cast<int>(gridDim.x) - 1;
    }
    __syncthreads();
    if (last) {
      __threadfence();
      run_final_phases<0>(kernel);
      if (threadIdx.x == 0) *kernel.ticket() = 0;
    }
  }
}

// ---- On the host.

// Throws an Error where a call of the driver failed.
inline void require(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  throw Error(ExitCode::invalid_input,
              std::string("--device cuda: ") + what + ": " + cudaGetErrorString(error) + "; --device cpu needs no GPU");
}

// The memory of the device, and one queue of work on it.
class Queue {
 public:
  Queue() { require(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "no queue for its work"); }
  ~Queue() { cudaStreamDestroy(stream_); }
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  static void* allocate(size_t bytes) {
    void* memory = nullptr;
    const cudaError_t error = cudaMalloc(&memory, bytes);
    if (error == cudaErrorMemoryAllocation) {
      cudaGetLastError();  // so that later calls do not report it again
      size_t free = 0, all = 0;
      cudaMemGetInfo(&free, &all);
      throw Error(ExitCode::invalid_input, "--device cuda: the card has " + std::to_string(free >> 20) + " of " +
                                               std::to_string(all >> 20) + " MB free, expected " +
                                               std::to_string((bytes >> 20) + 1) +
                                               " more; fewer runs at a time or --device cpu");
    }
    require(error, "no memory on the card");
    return memory;
  }
  static void release(void* memory) { cudaFree(memory); }

  void copy_in(void* to, const void* from, size_t bytes) {
    require(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_), "copying to the card failed");
  }
  // Waits until all work before it, and it, is done.
  void copy_out(void* to, const void* from, size_t bytes) {
    require(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_), "copying from the card failed");
    wait();
  }
  void copy_on(void* to, const void* from, size_t bytes) {
    require(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream_), "copying on the card failed");
  }
  void zero(void* memory, size_t bytes) {
    require(cudaMemsetAsync(memory, 0, bytes, stream_), "clearing memory of the card failed");
  }
  void wait() { require(cudaStreamSynchronize(stream_), "the card failed"); }

  template <class Kernel>
  void launch(int blocks, const typename Kernel::Arguments& arguments) {
    static_assert(Kernel::kThreads <= 1024 && sizeof(typename Kernel::Shared) <= 48 * 1024 - 16);
    static_assert(sizeof(typename Kernel::Arguments) <= 4096);
    if (blocks < 1) throw internal_error("a launch of no blocks");
    run_kernel<Kernel><<<blocks, Kernel::kThreads, 0, stream_>>>(arguments);
    require(cudaGetLastError(), "a kernel could not be started");
  }
  // Blocks that keep the device busy.
  template <class Kernel>
  int fitting_blocks() const {
    int device = 0, multiprocessors = 0, each = 0;
    require(cudaGetDevice(&device), "no card");
    require(cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, device), "no card");
    require(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&each, run_kernel<Kernel>, Kernel::kThreads, 0),
            "a kernel does not fit on it");
    return multiprocessors * (each > 0 ? each : 1);
  }

 private:
  cudaStream_t stream_ = nullptr;
};

}  // namespace physmas::mpm::PHYSMAS_GPU

#endif
