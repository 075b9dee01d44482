#include "base/kernels.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <utility>

#include "base/error.h"

namespace physmas {

#ifdef PHYSMAS_KERNEL_SETS

Kernels widest_kernels() {
  // The names are those of the makefile's -march.
  if (__builtin_cpu_supports("x86-64-v4")) return Kernels::avx512;
  if (__builtin_cpu_supports("x86-64-v3")) return Kernels::avx2;
  return Kernels::sse2;
}

Kernels chosen_kernels() {
  static const Kernels chosen = [] {
    const Kernels widest = widest_kernels();
    const char* wish = std::getenv("PM_KERNELS");
    if (wish == nullptr || *wish == '\0') return widest;
    std::string known;
    const std::pair<const char*, Kernels> sets[] = {
        {"sse2", Kernels::sse2}, {"avx2", Kernels::avx2}, {"avx512", Kernels::avx512}};
    for (const auto& [name, set] : sets) {
      if (set > widest) continue;
      if (std::string(name) == wish) return set;
      known += known.empty() ? name : std::string(" or ") + name;
    }
    throw Error(ExitCode::usage,
                fmt::format("PM_KERNELS: found \"{}\", expected {}, which this processor has", wish, known));
  }();
  return chosen;
}

#else

Kernels widest_kernels() {
  return Kernels::native;
}
Kernels chosen_kernels() {
  return Kernels::native;
}

#endif

const char* name_of(Kernels kernels) {
  switch (kernels) {
    case Kernels::avx512:
      return "AVX-512";
    case Kernels::avx2:
      return "AVX2";
    case Kernels::sse2:
      return "SSE2";
    case Kernels::native:
      break;
  }
#if defined(__AVX512F__)
  return "AVX-512";
#elif defined(__AVX2__)
  return "AVX2";
#elif defined(__SSE2__)
  return "SSE2";
#elif defined(__ARM_NEON)
  return "NEON";
#else
  return "128-bit vectors";
#endif
}

}  // namespace physmas
