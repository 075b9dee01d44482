#include "base/cuda_build.h"
#include "base/device.h"
#include "mpm/cuda/cuda_stepper.h"
#include "mpm/cuda/gpu_stepper.h"

namespace physmas {

#define PM_TEXT_2(x) #x
#define PM_TEXT(x) PM_TEXT_2(x)
const char* cuda_build() {
  return "with CUDA " PM_TEXT(__CUDACC_VER_MAJOR__) "." PM_TEXT(__CUDACC_VER_MINOR__);
}

std::string cuda_absence() {
  int cards = 0, driver = 0;
  if (cudaDriverGetVersion(&driver) != cudaSuccess || driver == 0) return "this machine has no NVIDIA driver";
  const cudaError_t counted = cudaGetDeviceCount(&cards);
  if (counted != cudaSuccess) return std::string("no card can be used (") + cudaGetErrorString(counted) + ")";
  if (cards == 0) return "this machine has no card";
  cudaFuncAttributes attributes;
  if (cudaFuncGetAttributes(&attributes, mpm::real_gpu::run_kernel<mpm::real_gpu::ChangeSlots>) == cudaSuccess)
    return "";
  cudaGetLastError();  // so that later calls do not report it again
  cudaDeviceProp card;
  if (cudaGetDeviceProperties(&card, 0) != cudaSuccess) return "the card cannot be used";
  return "this build has no kernels for the card, which needs CUDA_ARCH=" + std::to_string(card.major) +
         std::to_string(card.minor) + " when it is built";
}

namespace mpm {

std::unique_ptr<Stepper> make_cuda_stepper(int threads, Precision precision, const StepperSetup& setup) {
  if (precision == Precision::full) return std::make_unique<real_gpu::GpuStepper<double>>(threads, setup);
  return std::make_unique<real_gpu::GpuStepper<float>>(threads, setup);
}

}  // namespace mpm

}  // namespace physmas
