# Which processor the tools are built for. ARCH=native: this one. ARCH=baseline: any of its kind; where that is x86-64, the files
# of kernels are compiled once per set, and the tools take the widest set that the processor has (lib/base/kernels.h). Else ARCH
# is what -march takes. Included by the Makefile.

# The solver's step and the rasteriser.
KERNELS := lib/mpm/cpu/cpu_stepper.cpp lib/splat/raster.cpp

MARCH := $(ARCH)
ifeq ($(ARCH),baseline)
  ifeq ($(shell uname -m),x86_64)
    MARCH := x86-64
    KERNEL_SETS := sse2 avx2 avx512
  else
    MARCH := armv8-a
  endif
endif
march_of_sse2 := x86-64
march_of_avx2 := x86-64-v3
march_of_avx512 := x86-64-v4
KERNEL_OBJECTS := $(foreach k,$(KERNELS:.cpp=),$(KERNEL_SETS:%=$(BUILD)/obj/$(k).%.o))

# $(call kernel_rules,SET). Inline functions and templates of the standard library exist in every object that uses them, and a
# linker keeps any one of them: one that was compiled for wide registers would run on every processor. So an object of kernels
# keeps all of its own, and only what stands in the set's namespace, whose name has numbers around it when mangled, is seen from outside.
define kernel_rules
$(KERNELS:%.cpp=$(BUILD)/obj/%.$(1).o): $(BUILD)/obj/%.$(1).o: %.cpp | build/.packages
	@mkdir -p $$(@D)
	$$(call say,CXX,$$< ($(1)))
	$$(Q)$$(CXX) $$(CPPFLAGS) -DPHYSMAS_KERNELS=$(1) $$(CXXFLAGS) $$(OPT) -march=$(march_of_$(1)) -Wno-psabi -MMD -MP -MT $$@ -MF $$(@:.o=.d) -c $$< -o $$@.all
	$$(Q)ld -r --force-group-allocation $$@.all -o $$@.one && objcopy --wildcard --keep-global-symbol='*[0-9]$(1)[0-9]*' $$@.one $$@
	@rm -f $$@.all $$@.one
endef
$(foreach set,$(KERNEL_SETS),$(eval $(call kernel_rules,$(set))))
