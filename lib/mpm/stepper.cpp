#include "mpm/stepper.h"

#include <algorithm>
#include <thread>

#include "base/error.h"
#include "mpm/cpu/cpu_stepper.h"
#include "mpm/cuda/cuda_stepper.h"

namespace physmas::mpm {

std::unique_ptr<Stepper> make_stepper(const Device& device, Precision precision, const StepperSetup& setup) {
  require_device(device);
  if (device.kind == Device::Kind::cpu) return make_cpu_stepper(device.threads, precision, setup);
  if (setup.measure_steps) {
    throw Error(ExitCode::usage, "--device cuda: the energy of every substep is measured on the CPU only");
  }
  if (!setup.rigid.empty()) {
    throw Error(ExitCode::usage,
                "--device cuda: rows that keep their shape move on the CPU only; set time.stiff to off");
  }
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return make_cuda_stepper(device.threads > 0 ? std::min(device.threads, cores) : cores, precision, setup);
}

}  // namespace physmas::mpm
