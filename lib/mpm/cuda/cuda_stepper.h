// The stepper of an NVIDIA GPU, where the build has one (make with nvcc; docs/gpu.md).
#ifndef PHYSMAS_MPM_CUDA_CUDA_STEPPER_H
#define PHYSMAS_MPM_CUDA_CUDA_STEPPER_H

#include "mpm/stepper.h"

namespace physmas::mpm {

// threads: of the CPU, for sums over states; 0: all cores. An Error (exit code 2) for what a GPU does not do.
std::unique_ptr<Stepper> make_cuda_stepper(int threads, Precision precision, const StepperSetup& setup);

}  // namespace physmas::mpm

#endif
