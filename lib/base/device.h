// Where a tool computes.
#ifndef PHYSMAS_BASE_DEVICE_H
#define PHYSMAS_BASE_DEVICE_H

#include <string>

namespace physmas {

struct Device {
  enum class Kind { cpu, cuda };
  Kind kind = Kind::cpu;
  int threads = 0;  // of the CPU, 0: all cores
};

// What `--device auto|cpu|cuda` asks for; auto: the fastest that is there.
Device choose_device(const std::string& name, int threads);

// Throws a usage error (exit code 2) for a device that this build or this machine lacks: nothing takes its place.
void require_device(const Device& device);

}  // namespace physmas

#endif
