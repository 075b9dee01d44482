# PhysMAS: build, demo, run, test. `make help` lists the targets.
#
# One non-recursive makefile. Objects go to build/ (build/san with SAN=1); the DAG of a run is
# pipelines/physmas.mk. Local settings may be put into Makefile.local, which git ignores.

-include Makefile.local

SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -c
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules --no-builtin-variables

VERSION := 0.1.0
CXX ?= g++
ifeq ($(origin CXX),default)
CXX := g++
endif
ARCH ?= native
OPT ?= -O3
SAN ?= 0

ifeq ($(SAN),1)
BUILD ?= build/san
# Leak checking is on; the frame pointer keeps the stacks readable.
MODE_FLAGS := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined
else
BUILD ?= build
MODE_FLAGS := $(OPT) -DNDEBUG
endif

CPPFLAGS := -Ilib -I$(BUILD)/gen -isystem /usr/include/hdf5/serial -isystem /usr/include/opencv4 \
            -isystem /usr/include/eigen3 -DPHYSMAS_VERSION='"$(VERSION)"'
CXXFLAGS := -std=c++17 -march=$(ARCH) $(MODE_FLAGS) -fopenmp -fno-math-errno -fno-trapping-math \
            -Wall -Wextra -Wno-unknown-pragmas $(if $(WERROR),-Werror) $(EXTRA_CXXFLAGS)
, := ,
LDFLAGS := -fopenmp $(if $(filter 1,$(SAN)),-fsanitize=address$(,)undefined) -Wl,--as-needed
LDLIBS := -L/usr/lib/x86_64-linux-gnu/hdf5/serial -L/usr/lib/aarch64-linux-gnu/hdf5/serial -lhdf5 \
          -lopencv_videoio -lopencv_imgcodecs -lopencv_imgproc -lopencv_core \
          -lavformat -lavcodec -lswscale -lavutil -lcurl -lcrypto -lfmt

LIB_SOURCES := $(wildcard lib/*/*.cpp)
TOOL_SOURCES := $(wildcard tools/*.cpp)
UNIT_SOURCES := $(wildcard tests/unit/*.cpp)
BENCH_SOURCES := $(wildcard tests/bench/*.cpp)
SCHEMAS := $(wildcard schemas/*.json)
TOOLS := $(TOOL_SOURCES:tools/%.cpp=%)
BIN := $(BUILD)/bin

objects = $(patsubst %.cpp,$(BUILD)/obj/%.o,$(1))
LIB_OBJECTS := $(call objects,$(LIB_SOURCES)) $(BUILD)/obj/gen/schemas.o
LIBRARY := $(BUILD)/libphysmas.a

.PHONY: all
all: $(TOOLS:%=$(BIN)/%) ## Build the tools into build/bin (make -j2)

$(BUILD)/obj/%.o: %.cpp | deps-present
	@mkdir -p $(@D)
	$(call say,CXX,$<)
	$(Q)$(CXX) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

# The JSON Schemas travel inside the binaries, so that a tool can be moved without its tree.
$(BUILD)/gen/schemas.cpp: $(SCHEMAS) Makefile
	@mkdir -p $(@D)
	@{ echo '// Generated from schemas/*.json by the Makefile.'; \
	   echo '#include "records/schema_text.h"'; \
	   echo 'namespace physmas { const SchemaText kSchemaTexts[] = {'; \
	   for f in $(SCHEMAS); do b=$${f#schemas/}; printf '{"%s", R"pmschema(' "$$b"; cat "$$f"; echo ')pmschema"},'; done; \
	   echo '}; const int kSchemaTextCount = sizeof(kSchemaTexts) / sizeof(kSchemaTexts[0]); }'; } > $@

$(BUILD)/obj/gen/schemas.o: $(BUILD)/gen/schemas.cpp
	@mkdir -p $(@D)
	$(Q)$(CXX) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

$(LIBRARY): $(LIB_OBJECTS)
	@rm -f $@
	$(call say,AR,$@)
	$(Q)ar rcs $@ $^

$(BIN)/%: $(BUILD)/obj/tools/%.o $(LIBRARY)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

$(BUILD)/test/unit: $(call objects,$(UNIT_SOURCES)) $(LIBRARY)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

V ?= 0
Q := $(if $(filter 0,$(V)),@)
say = $(if $(filter 0,$(V)),@printf '  %-5s %s\n' '$(1)' '$(2)')

.PRECIOUS: $(BUILD)/obj/%.o
-include $(patsubst %.o,%.d,$(LIB_OBJECTS) $(call objects,$(TOOL_SOURCES) $(UNIT_SOURCES) $(BENCH_SOURCES)))

# Packages of a bare Debian 12 that the project needs: one list for people, make and CI.
PACKAGES := g++ make pkg-config libeigen3-dev libhdf5-dev libopencv-core-dev libopencv-imgproc-dev \
            libopencv-imgcodecs-dev libopencv-videoio-dev libavcodec-dev \
            libavformat-dev libavutil-dev libswscale-dev nlohmann-json3-dev libvalijson-dev \
            libcurl4-openssl-dev libssl-dev libcli11-dev libfmt-dev libnanoflann-dev doctest-dev bats gnuplot-nox

.PHONY: deps-present
deps-present:
