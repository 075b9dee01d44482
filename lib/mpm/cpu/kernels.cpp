// The solver's kernels for the processor at hand.
#include "base/kernels.h"

#include "mpm/cpu/cpu_stepper.h"

namespace physmas::mpm {

PHYSMAS_DECLARE_KERNEL(std::unique_ptr<Stepper>, make_cpu_stepper, int threads, Precision precision,
                       const StepperSetup& setup)

std::unique_ptr<Stepper> make_cpu_stepper(int threads, Precision precision, const StepperSetup& setup) {
  return PHYSMAS_CHOSEN_KERNEL(make_cpu_stepper)(threads, precision, setup);
}

}  // namespace physmas::mpm
