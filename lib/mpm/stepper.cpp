#include "mpm/stepper.h"

#include "mpm/cpu/cpu_stepper.h"

namespace physmas::mpm {

std::unique_ptr<Stepper> make_stepper(const Device& device, Precision precision, const StepperSetup& setup) {
  require_device(device);
  return make_cpu_stepper(device.threads, precision, setup);
}

}  // namespace physmas::mpm
