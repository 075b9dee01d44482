#include "mpm/cuda/cuda_stepper.h"
#include "mpm/cuda/gpu_stepper.h"

namespace physmas::mpm {

std::unique_ptr<Stepper> make_cuda_stepper(int threads, Precision precision, const StepperSetup& setup) {
  if (precision == Precision::full) return std::make_unique<real_gpu::GpuStepper<double>>(threads, setup);
  return std::make_unique<real_gpu::GpuStepper<float>>(threads, setup);
}

}  // namespace physmas::mpm
