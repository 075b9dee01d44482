// In builds without nvcc; else lib/mpm/cuda/cuda_stepper.cu says what is there.
#include "base/cuda_build.h"
#include "base/device.h"

namespace physmas {

const char* cuda_build() {
  return "without CUDA";
}

std::string cuda_absence() {
  return "this build has no CUDA back end";
}

}  // namespace physmas
