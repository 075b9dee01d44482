# The solver, its GPU tests and benchmark from the sources that need no package: make -f tests/gpu/bare/bare.mk, from the top.
# With CUDA_ARCH they run on the card, without it the tests run in the emulator.
SHELL := /bin/bash
.DEFAULT_GOAL := all
OUT ?= build/gpu
NVCC ?= $(firstword $(shell command -v nvcc) $(wildcard /usr/local/cuda/bin/nvcc))
SAN ?= 0
BUILD := $(OUT)
Q := @
say = @printf '  %-5s %s\n' '$(1)' '$(2)'
CUDA_ARCH ?=
CUDA ?= 1
include packaging/cuda.mk

SOURCES := $(filter-out lib/mpm/equilibrium.cpp lib/mpm/action/nearest.cpp lib/mpm/cuda/no_cuda.cpp,$(wildcard lib/mpm/*.cpp lib/mpm/action/*.cpp \
             lib/mpm/cpu/*.cpp lib/mpm/material/*.cpp)) $(patsubst %,lib/base/%.cpp,device error printable team) tests/gpu/bare/base.cpp \
           $(if $(CUDA_OBJECTS),,$(WITHOUT_CUDA))
CXXFLAGS := -std=c++17 -O2 -march=native -fopenmp -fno-math-errno -fno-trapping-math -Ilib -Itests -Wno-psabi \
            $(if $(filter 1,$(SAN)),-g -fsanitize=address$(,)undefined -fno-sanitize-recover=undefined)
OBJECTS := $(SOURCES:%.cpp=$(OUT)/obj/%.o) $(CUDA_OBJECTS)

.PHONY: all
all: $(OUT)/check $(OUT)/bench
$(OUT)/obj/%.o: %.cpp
	@mkdir -p $(@D)
	$(call say,CXX,$*)
	$(Q)$(CXX) $(CXXFLAGS) $(if $(filter tests/%,$*),-Itests/gpu/bare) -MMD -MP -c $< -o $@
$(OUT)/check: $(OUT)/obj/tests/gpu/bare/main.o $(OUT)/obj/tests/gpu/bare/nearest.o $(OUT)/obj/tests/unit/mpm/cuda/gpu_stepper.o $(OBJECTS)
$(OUT)/bench: $(OUT)/obj/tests/gpu/bench.o $(OUT)/obj/tests/gpu/bare/nearest.o $(OBJECTS)
$(OUT)/check $(OUT)/bench:
	$(call say,LINK,$@)
	$(Q)$(CXX) $(CXXFLAGS) $^ $(CUDA_LIBS) -o $@
-include $(wildcard $(OUT)/obj/*/*/*.d $(OUT)/obj/*/*/*/*.d $(OUT)/obj/*/*/*/*/*.d)
