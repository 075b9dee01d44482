// Where a tool computes.
#ifndef PHYSMAS_BASE_DEVICE_H
#define PHYSMAS_BASE_DEVICE_H

#include <string>

namespace physmas {

struct Device {
  enum class Kind { cpu, cuda };
  Kind kind = Kind::cpu;
  int threads = 0;         // of the CPU, 0: all cores
  bool automatic = false;  // the CPU, unless a tool finds that its work is worth a GPU
};

// What `--device auto|cpu|cuda` asks for.
Device choose_device(const std::string& name, int threads);

// Throws a usage error (exit code 2) for a device that this build or this machine lacks: nothing takes its place.
void require_device(const Device& device);

// Why no GPU can be used, in a few words: the build has no kernels, or none for the card; there is no driver, or no
// card. Empty where one can. Looking takes a moment where there is a driver.
std::string cuda_absence();

}  // namespace physmas

#endif
