// A build without nvcc: no stepper of a GPU.
#include "base/error.h"
#include "mpm/cuda/cuda_stepper.h"

namespace physmas::mpm {

std::unique_ptr<Stepper> make_cuda_stepper(int, Precision, const StepperSetup&) {
  throw internal_error("this build has no stepper of a GPU");  // require_device has refused it before
}

}  // namespace physmas::mpm
