// What a build has for GPUs.
#ifndef PHYSMAS_BASE_CUDA_BUILD_H
#define PHYSMAS_BASE_CUDA_BUILD_H

namespace physmas {

// "with CUDA 13.0" or "without CUDA".
const char* cuda_build();

}  // namespace physmas

#endif
