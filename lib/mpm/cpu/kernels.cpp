// The solver's kernels for the processor at hand.
#include "base/kernels.h"

#include "mpm/stepper.h"

namespace physmas::mpm {

PHYSMAS_DECLARE_KERNEL(std::unique_ptr<Stepper>, make_stepper, Precision precision, const StepperSetup& setup)

std::unique_ptr<Stepper> make_stepper(Precision precision, const StepperSetup& setup) {
  return PHYSMAS_CHOSEN_KERNEL(make_stepper)(precision, setup);
}

}  // namespace physmas::mpm
