#include "mpm/device_choice.h"

#include <algorithm>
#include <cmath>
#include <thread>

namespace physmas::mpm {

namespace {

// Of one thread, float, all that a substep does: docs/performance.md has what machines reach.
constexpr double kParticleStepsPerSecond = 5e6;
// Starting a driver and copying take a second or two; a GPU that saves less is not worth its noise.
constexpr double kWorthSeconds = 10;

double cpu_seconds(const Problem& problem, const Timing& timing, const Options& options) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int threads = options.device.threads > 0 ? std::min(options.device.threads, cores) : cores;
  const double steps = static_cast<double>(timing.substeps) * (timing.frames - 1);
  const double speed = kParticleStepsPerSecond * threads / (options.precision == Precision::full ? 2 : 1);
  return static_cast<double>(problem.particles.size()) * steps / speed;
}

}  // namespace

DeviceChoice choose_device(const Problem& problem, const Timing& timing, const Options& options,
                           const std::function<std::string()>& absence) {
  Device device = options.device;
  if (!device.automatic) return {device, "asked for"};
  device.automatic = false;
  device.kind = Device::Kind::cpu;
  if (options.measure_steps) return {device, "the energy of every substep is measured on the CPU only"};
  const double seconds = cpu_seconds(problem, timing, options);
  if (seconds < kWorthSeconds) {
    return {device, "at most " + std::to_string(static_cast<int>(std::ceil(seconds))) +
                        " s of work: less than a GPU is worth starting for"};
  }
  const std::string lacking = absence();
  if (!lacking.empty()) return {device, lacking};
  device.kind = Device::Kind::cuda;
  return {device, "about " + std::to_string(static_cast<int>(seconds)) + " s of work for the CPU"};
}

}  // namespace physmas::mpm
