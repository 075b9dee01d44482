// What the kernels of this folder are written with, in two worlds: a GPU, where nvcc compiles them, and an emulator of
// blocks and threads, in which every compiler's tests run them.
//
// A kernel is a class. Its threads come in blocks, and what a thread does between two barriers of its block is a phase:
//
//   struct Arguments;               passed by value
//   struct Shared;                  of a block
//   static constexpr int kThreads;  of a block
//   static constexpr int kResident; blocks that a multiprocessor should hold at a time, which bounds the registers
//   static constexpr int kPhases, kFinalPhases;
//   Kernel(const Arguments&, Shared&, int thread);
//   int items() const;              what is to be done, the same for all threads; blocks take items in turn
//   template <int kPhase> void phase(int item);
//   int* ticket() const;            0 between launches; with final phases only
//   template <int kPhase> void final_phase();  run by the block that ends last, which sees what all have written
//
// What a thread keeps from phase to phase are the members of its object. A phase may write to shared memory what later
// ones read; in a phase threads meet through the atomic functions below alone. So a plain loop over the threads, phase
// by phase, is all that the emulator needs, and it can take them in any order.
#ifndef PHYSMAS_MPM_CUDA_GPU_H
#define PHYSMAS_MPM_CUDA_GPU_H

#ifdef __CUDACC__
#include "mpm/cuda/real_gpu.h"
#else
#include "mpm/cuda/emulated_gpu.h"
#endif

#endif
