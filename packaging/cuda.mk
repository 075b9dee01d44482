# Kernels for NVIDIA GPUs (docs/gpu.md). They are compiled when nvcc is found and CUDA_ARCH says for what: by default for the card
# of this machine, where there is one; CUDA_ARCH="75 80 86 89 90 100 120" for all, CUDA=0 for none. Without them everything builds
# and runs, on the CPU. Included by the Makefile.

NVCC ?= $(firstword $(shell command -v nvcc) $(wildcard /usr/local/cuda/bin/nvcc))
CUDA ?= 1
# What the build has been made for; nvidia-smi takes a second to say what the card is.
cuda_built_for := $(BUILD)/cuda-arch
ifeq ($(origin CUDA_ARCH),undefined)
  CUDA_ARCH := $(if $(and $(NVCC),$(if $(filter 0,$(CUDA)),,y)),$(or $(file <$(cuda_built_for)),$(shell nvidia-smi --query-gpu=compute_cap --format=csv,noheader 2>/dev/null | tr -d . | sort -un)))
endif
cuda_architectures := $(if $(NVCC),$(if $(filter 0,$(CUDA)),,$(if $(filter 1,$(SAN)),,$(CUDA_ARCH))))
ifneq ($(filter-out 50 52 53 60 61 62 70 72 75 80 86 87 88 89 90 100 101 103 110 120 121,$(cuda_architectures)),)
  $(error CUDA_ARCH: found '$(cuda_architectures)', expected compute capabilities without their dot, such as "86" or "75 80 86 89 90")
endif

# What takes the place of what.
CUDA_SOURCES := lib/mpm/cuda/cuda_stepper.cu
WITHOUT_CUDA := lib/base/no_cuda.cpp lib/mpm/cuda/no_cuda.cpp
CUDA_OBJECTS := $(if $(cuda_architectures),$(CUDA_SOURCES:%.cu=$(BUILD)/obj/%.o))

# Divisions and roots of float are approximate, within two units of the last digit. A newer card than the newest compiles the
# text of its kernels for itself.
newest := $(lastword $(shell printf '%s\n' $(cuda_architectures) | sort -n))
CUDA_FLAGS := -std=c++17 -O3 -Ilib -prec-div=false -prec-sqrt=false --Werror all-warnings
CUDA_CARDS := $(foreach a,$(cuda_architectures),-gencode arch=compute_$(a),code=sm_$(a)) -gencode arch=compute_$(newest),code=compute_$(newest)
# The runtime is linked in, and looks for the driver when it is asked: tools start where there is none.
cuda_root := $(if $(NVCC),$(patsubst %/bin/,%,$(dir $(realpath $(NVCC)))))
cuda_folder := $(dir $(firstword $(wildcard $(addsuffix /libcudart_static.a,$(cuda_root)/lib64 $(cuda_root)/lib $(cuda_root)/targets/*/lib /usr/lib/*-linux-gnu))))
CUDA_LIBS := $(if $(cuda_architectures),-L$(cuda_folder) -lcudart_static -ldl -lrt -lpthread)

# The objects, and the library that has them or does without, follow what was asked for. A build without a GPU has no such file.
# Where nothing is built, nothing is written.
cuda_builds := $(if $(findstring n,$(filter-out --%,$(firstword -$(MAKEFLAGS)))),,$(filter-out check-cuda check-cuda-all help clean,$(or $(MAKECMDGOALS),all)))
ifneq ($(if $(cuda_builds),$(strip $(file <$(cuda_built_for)))),$(if $(cuda_builds),$(strip $(cuda_architectures))))
  $(shell mkdir -p $(BUILD))
  $(file >$(cuda_built_for),$(strip $(cuda_architectures)))
endif
ifneq ($(CUDA_OBJECTS),)
$(CUDA_OBJECTS): $(BUILD)/obj/%.o: %.cu $(cuda_built_for)
	@mkdir -p $(@D)
	$(call say,NVCC,$* (for $(strip $(cuda_architectures))))
	$(Q)$(NVCC) $(CUDA_FLAGS) $(CUDA_CARDS) -MMD -MP -MF $(@:.o=.d) -c $< -o $@
ifeq ($(MAKE_RESTARTS),)
-include $(CUDA_OBJECTS:.o=.d)
endif
endif
