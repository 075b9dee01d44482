// Wall-clock seconds for run-time reports. Never part of a result.
#ifndef PHYSMAS_BASE_CLOCK_H
#define PHYSMAS_BASE_CLOCK_H

#include <sys/resource.h>

#include <chrono>

namespace physmas {

class Stopwatch {
 public:
  // Seconds since construction.
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Largest resident size of this process so far [bytes].
inline long long peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<long long>(usage.ru_maxrss) * 1024;
}

}  // namespace physmas

#endif
