// Kernels: functions that are as fast as the processor's registers are wide. Built for one processor (ARCH=native)
// their files are compiled once. Built for any (ARCH=baseline), the makefile compiles the files that it lists in
// KERNELS once per set, for SSE2, AVX2 and AVX-512, and the widest set that the processor has is taken when the program
// runs.
//
// A file of kernels defines them in `namespace PHYSMAS_KERNELS`, and nothing else of it is seen by other files: inline
// functions compiled for wide registers must not take the place of those that every processor runs.
#ifndef PHYSMAS_BASE_KERNELS_H
#define PHYSMAS_BASE_KERNELS_H

namespace physmas {

// native: whatever the program was compiled for.
enum class Kernels { native, sse2, avx2, avx512 };

// The widest set that was built and that the processor has.
Kernels widest_kernels();
// That, or the set that the environment variable PM_KERNELS names: sse2, avx2 or avx512. An Error (usage) when there is
// no such set, or when it is wider than the processor.
Kernels chosen_kernels();
// "AVX-512", "AVX2", "SSE2", or what other processors call their registers.
const char* name_of(Kernels kernels);

// PHYSMAS_DECLARE_KERNEL(int, area, double a, double b) declares what each set defines; PHYSMAS_CHOSEN_KERNEL(area) is
// the chosen set's.
#ifndef PHYSMAS_KERNELS
#define PHYSMAS_KERNELS native
#endif
#ifdef PHYSMAS_KERNEL_SETS
#define PHYSMAS_DECLARE_KERNEL(Result, name, ...) \
  namespace sse2 {                                \
  Result name(__VA_ARGS__);                       \
  }                                               \
  namespace avx2 {                                \
  Result name(__VA_ARGS__);                       \
  }                                               \
  namespace avx512 {                              \
  Result name(__VA_ARGS__);                       \
  }
#define PHYSMAS_CHOSEN_KERNEL(name) \
  (chosen_kernels() == Kernels::avx512 ? avx512::name : chosen_kernels() == Kernels::avx2 ? avx2::name : sse2::name)
#else
#define PHYSMAS_DECLARE_KERNEL(Result, name, ...) \
  namespace native {                              \
  Result name(__VA_ARGS__);                       \
  }
#define PHYSMAS_CHOSEN_KERNEL(name) native::name
#endif

}  // namespace physmas

#endif
