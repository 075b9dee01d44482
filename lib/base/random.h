// Random numbers that are the same on every machine: the standard fixes the generator but not its distributions.
#ifndef PHYSMAS_BASE_RANDOM_H
#define PHYSMAS_BASE_RANDOM_H

#include <cstdint>
#include <random>

namespace physmas {

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  // Uniform in [0, 1): 53 random bits, exact.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  // Uniform in [-1, 1).
  double symmetric() { return 2 * uniform() - 1; }
  uint64_t bits() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace physmas

#endif
