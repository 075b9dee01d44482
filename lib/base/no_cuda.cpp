// In builds without nvcc; else lib/mpm/cuda/cuda_stepper.cu says what is there.
#include "base/device.h"

namespace physmas {

std::string cuda_absence() {
  return "this build has no CUDA back end";
}

}  // namespace physmas
