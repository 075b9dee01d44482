# PhysMAS: build, demo, run, test. `make help` lists the targets.
#
# One non-recursive makefile. Objects go to build/ (build/san with SAN=1); the DAG of a run is
# pipelines/physmas.mk. Local settings may be put into Makefile.local, which git ignores.

include pipelines/literal.mk
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
# Loops over particles, Gaussians and pixels, and everything else.
OPT ?= -O3
PLAIN_OPT ?= -O1
SAN ?= 0

ifeq ($(SAN),1)
BUILD ?= build/san
# Leak checking is on; the frame pointer keeps the stacks readable.
OPT := -O1
PLAIN_OPT := -O1
MODE_FLAGS := -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined
else
BUILD ?= build
MODE_FLAGS := -DNDEBUG
endif

# Lists of headers name objects as they were called when they were compiled: in this tree by one name only.
override BUILD := $(patsubst $(CURDIR)/%,%,$(BUILD))

.DEFAULT_GOAL := all
include packaging/kernels.mk packaging/cuda.mk

CPPFLAGS := -Ilib -Itests -I$(BUILD)/gen -isystem /usr/include/hdf5/serial -isystem /usr/include/opencv4 \
            -isystem /usr/include/eigen3 -DPHYSMAS_VERSION='"$(VERSION)"' $(if $(KERNEL_SETS),-DPHYSMAS_KERNEL_SETS)
CXXFLAGS := -std=c++17 -march=$(MARCH) $(MODE_FLAGS) -fopenmp -fno-math-errno -fno-trapping-math \
            -Wall -Wextra -Wno-unknown-pragmas $(if $(findstring clang,$(CXX)),,-Wno-maybe-uninitialized -Wno-uninitialized) $(if $(WERROR),-Werror) $(EXTRA_CXXFLAGS)
, := ,
LDFLAGS := -fopenmp $(if $(filter 1,$(SAN)),-fsanitize=address$(,)undefined) -Wl,--as-needed
LDLIBS := -L/usr/lib/x86_64-linux-gnu/hdf5/serial -L/usr/lib/aarch64-linux-gnu/hdf5/serial -lhdf5 \
          -lopencv_video -lopencv_imgcodecs -lopencv_imgproc -lopencv_core \
          -lavformat -lavcodec -lswscale -lavutil -lcurl -lcrypto -lz -lzstd -lzip -lfmt $(CUDA_LIBS)

LIB_SOURCES := $(filter-out $(if $(CUDA_OBJECTS),$(WITHOUT_CUDA)),$(wildcard lib/*/*.cpp lib/*/*/*.cpp))
TOOL_SOURCES := $(wildcard tools/*.cpp)
UNIT_SOURCES := $(wildcard $(addprefix tests/unit/,*.cpp */*.cpp */*/*.cpp))
TEST_TOOL_SOURCES := $(wildcard tests/tools/*.cpp)
BENCH_SOURCES := $(wildcard tests/bench/*.cpp)
EMBEDDED_TEXTS := $(sort $(wildcard schemas/*.json lib/*/prompts/*.txt lib/*/words/*.txt $(addprefix lib/*/pages/*.,html css js)))
TOOLS := $(TOOL_SOURCES:tools/%.cpp=%)
TEST_TOOLS := $(TEST_TOOL_SOURCES:tests/tools/%.cpp=$(BUILD)/test/%)
BIN := $(BUILD)/bin

# Most of what a source takes to compile is what it includes and the templates of that, so several sources of a folder are
# compiled at a time; their object is named after them, lib/lift/assignment+evidence.o. TOGETHER=1 compiles each alone, as
# always those that take long or decide speed. Sources with JSON keep together: what they share takes longer.
TOGETHER ?= 6
ALONE := $(KERNELS) $(WITHOUT_CUDA) $(addprefix lib/,base/command_line.cpp records/validator.cpp splat/sh_rotation.cpp)
JSON_SOURCES := $(shell grep -rlE '^.include "records/(json|((json|run)_)?fields)\.h"' --include=*.cpp lib tools tests)
rest := $(shell echo $$(($(TOGETHER) + 1)))
# $(call joined,NAMES): one word for each TOGETHER of them.
joined = $(if $(1),$(subst $(empty) $(empty),+,$(wordlist 1,$(TOGETHER),$(1))) $(call joined,$(wordlist $(rest),999,$(1))))
# $(call folder_objects,FOLDER/,SOURCES)
folder_objects = $(patsubst %,$(BUILD)/obj/$(1)%.o,$(call joined,$(patsubst $(1)%.cpp,%,$(filter $(JSON_SOURCES),$(2)))) \
                   $(call joined,$(patsubst $(1)%.cpp,%,$(filter-out $(JSON_SOURCES),$(2)))))
# Each tool and test program has a main, each test its own small helpers.
alone = $(filter $(ALONE) tools/% tests/%,$(1))
objects = $(patsubst %.cpp,$(BUILD)/obj/%.o,$(alone)) $(foreach d,$(sort $(dir $(filter-out $(alone),$(1)))),\
            $(call folder_objects,$(d),$(foreach f,$(filter-out $(alone),$(1)),$(if $(filter $(d),$(dir $(f))),$(f)))))
# $(call sources_of,STEM): the sources of build/obj/STEM.o.
sources_of = $(foreach name,$(subst +, ,$(notdir $(1))),$(dir $(1))$(name).cpp)
# What only pm-eval needs is a library of its own: a run does not wait for it.
EVAL_SOURCES := $(filter lib/metrics/% lib/studies/% lib/tables/%,$(LIB_SOURCES))
EVAL_OBJECTS := $(call objects,$(EVAL_SOURCES))
RUN_OBJECTS := $(call objects,$(filter-out $(EVAL_SOURCES) $(if $(KERNEL_SETS),$(KERNELS)),$(LIB_SOURCES))) $(KERNEL_OBJECTS) $(CUDA_OBJECTS) $(BUILD)/obj/gen/embedded_texts.o
RUN_LIBRARY := $(BUILD)/libphysmas.a
EVAL_LIBRARY := $(BUILD)/libphysmas-eval.a
LIBRARIES := $(EVAL_LIBRARY) $(RUN_LIBRARY)

.PHONY: all
all: $(TOOLS:%=$(BIN)/%) ## Build the tools into build/bin (make -j2)

# --- Compilation --------------------------------------------------------------------------------------------------

# The rooms whose loops take a run's time are compiled for speed. Everything else is compiled quickly, and without
# contraction to fused multiply-adds, so that no decision depends on the processor.
FAST_ROOMS := bind bundle lift masks metrics mpm plan report scene splat studies
way = $(if $(filter $(FAST_ROOMS:%=lib/%/%) tests/bench/% tests/gpu/%,$(1)),fast,plain)
fast_FLAGS := $(OPT)
plain_FLAGS := $(PLAIN_OPT) -ffp-contract=off

# g++ reads what most sources include of Eigen, {fmt} and the standard library once and keeps it; JSON, which costs as
# much again, only for the sources that include it themselves. A precompiled header brings the flags along that it was
# made with, so there is one for each way. Every source still includes what it uses: PRECOMPILE=0 and clang++ tell.
PRECOMPILE ?= $(if $(findstring clang,$(CXX)),0,1)
common = $(if $(filter $(JSON_SOURCES),$(1)),records/json_headers.h,base/common_headers.h)
ifeq ($(PRECOMPILE),1)
precompiled = $(BUILD)/precompiled/$(way)/$(common).gch
precompiled_FLAGS = -I$(BUILD)/precompiled/$(way) -include $(common) -Winvalid-pch -fpch-preprocess
export CCACHE_SLOPPINESS := pch_defines,time_macros
endif
# g++ collects its garbage after every few megabytes, which with a precompiled header means all of that.
CXX_MEMORY := $(if $(findstring clang,$(CXX)),,--param ggc-min-heapsize=400000)
# The folder of precompiled headers goes first: the header itself is found in lib/.
compile = $(CXX) $(precompiled_FLAGS) $(CPPFLAGS) $(CXXFLAGS) $($(way)_FLAGS) $(CXX_MEMORY) \
            $(patsubst %,-include %,$(filter-out $(lastword $(1)),$(1))) -MMD -MP -c $(lastword $(1))

.SECONDEXPANSION:
$(BUILD)/obj/%.o: $$(call sources_of,$$*) $$(call precompiled,$$(call sources_of,$$*)) | build/.packages
	@mkdir -p $(@D)
	$(call say,CXX,$*)
	$(Q)$(call compile,$(call sources_of,$*)) -o $@

$(BUILD)/precompiled/fast/%.gch: lib/% | build/.packages
	@mkdir -p $(@D)
	$(call say,CXX,$< (fast))
	$(Q)$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(fast_FLAGS) $(CXX_MEMORY) -MD -MP -x c++-header $< -o $@

$(BUILD)/precompiled/plain/%.gch: lib/% | build/.packages
	@mkdir -p $(@D)
	$(call say,CXX,$< (plain))
	$(Q)$(CXX) $(CPPFLAGS) $(CXXFLAGS) $(plain_FLAGS) $(CXX_MEMORY) -MD -MP -x c++-header $< -o $@
-include $(wildcard $(BUILD)/precompiled/*/*/*.d)

# Schemas, prompts of the agents, tables of words and pages travel inside the binaries, so that a tool can be moved without
# its tree.
$(BUILD)/gen/embedded_texts.cpp: $(EMBEDDED_TEXTS) Makefile
	@mkdir -p $(@D)
	@{ echo '// Generated by the Makefile.'; \
	   echo '#include "base/embedded_text.h"'; \
	   echo 'namespace physmas { const EmbeddedText kEmbeddedTexts[] = {'; \
	   for f in $(EMBEDDED_TEXTS); do printf '{"%s", R"pmtext(' "$$f"; cat "$$f"; echo ')pmtext"},'; done; \
	   echo '}; const int kEmbeddedTextCount = sizeof(kEmbeddedTexts) / sizeof(kEmbeddedTexts[0]); }'; } > $@

$(BUILD)/obj/gen/%.o: $(BUILD)/gen/%.cpp
	@mkdir -p $(@D)
	$(Q)$(CXX) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

$(RUN_LIBRARY): $(RUN_OBJECTS) $(wildcard $(cuda_built_for))
$(EVAL_LIBRARY): $(EVAL_OBJECTS)
$(LIBRARIES):
	@rm -f $@
	$(call say,AR,$@)
	$(Q)ar rcs $@ $(filter %.o,$^)

$(BIN)/%: $(BUILD)/obj/tools/%.o $$(if $$(filter pm-eval,$$*),$(EVAL_LIBRARY)) $(RUN_LIBRARY)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

$(BUILD)/test/unit: $(call objects,$(UNIT_SOURCES)) $(LIBRARIES)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

# Programs that write fixtures for the command-line tests: tests/tools/NAME.cpp -> build/test/NAME.
$(TEST_TOOLS): $(BUILD)/test/%: $(BUILD)/obj/tests/tools/%.o $(LIBRARIES)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

# For LD_PRELOAD: lets a call of the system fail (tests/faults). It has no flags of a sanitizer, which wants to be first.
FAILING_CALLS := $(BUILD)/test/failing_calls.so
$(FAILING_CALLS): tests/faults/failing_calls.cpp | build/.packages
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) -std=c++17 -O1 -Wall -Wextra $(if $(WERROR),-Werror) -shared -fPIC $< -ldl -o $@

V ?= 0
Q := $(if $(filter 0,$(V)),@)
say = $(if $(filter 0,$(V)),@printf '  %-5s %s\n' '$(1)' '$(2)')

.PRECIOUS: $(BUILD)/obj/%.o $(BUILD)/precompiled/fast/%.gch $(BUILD)/precompiled/plain/%.gch
# A run reads this file several times (pipelines/physmas.mk); header dependencies matter the first time only.
ifeq ($(MAKE_RESTARTS),)
-include $(patsubst %.o,%.d,$(RUN_OBJECTS) $(EVAL_OBJECTS) $(call objects,$(TOOL_SOURCES) $(UNIT_SOURCES) $(TEST_TOOL_SOURCES) $(BENCH_SOURCES) tests/gpu/bench.cpp \
            $(wildcard tests/fuzz/*.cpp)))
endif

# --- What a bare Debian 12 lacks: one list for people, make and CI ------------------------------------------------

PACKAGES := g++ make libeigen3-dev libhdf5-dev libopencv-core-dev libopencv-imgproc-dev \
            libopencv-imgcodecs-dev libopencv-video-dev zlib1g-dev libzstd-dev libzip-dev libavcodec-dev \
            libavformat-dev libavutil-dev libswscale-dev nlohmann-json3-dev libvalijson-dev \
            libssl-dev libcurl4-openssl-dev libcli11-dev libfmt-dev libnanoflann-dev doctest-dev bats python3 \
            gnuplot-nox

# What dpkg does not report as installed. Empty where there is no dpkg: the compiler will tell.
find_missing = if command -v dpkg-query >/dev/null; then for p in $(PACKAGES); do \
    dpkg-query -W -f '$${Status}' $$p 2>/dev/null | grep -q ' installed' || printf '%s ' $$p; done; fi

install_missing = lacking=$$($(find_missing)); \
  if [ -n "$$lacking" ]; then \
    if [ "$$(id -u)" -eq 0 ]; then as=; \
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then as=sudo; \
    else echo "Missing packages, and neither root nor password-less sudo to install them. Run:" >&2; \
         echo "  sudo apt-get update && sudo apt-get install -y --no-install-recommends $$lacking" >&2; exit 1; fi; \
    echo "Installing $$lacking"; \
    $$as apt-get update -qq && \
    DEBIAN_FRONTEND=noninteractive $$as apt-get install -y -qq --no-install-recommends $$lacking; \
  fi

.PHONY: deps
deps: ## Install missing packages through apt-get (as root or with sudo)
	@$(install_missing)
	@mkdir -p build && touch build/.packages && echo "All packages are installed."

# Checked once before the first compilation, so that a missing header is explained. `make demo` installs by itself.
build/.packages: Makefile
ifneq ($(filter demo,$(MAKECMDGOALS)),)
	@$(install_missing)
else
	@lacking=$$($(find_missing)); if [ -n "$$lacking" ]; then \
	  echo "Missing packages: $$lacking" >&2; echo "Run: make deps" >&2; exit 1; fi
endif
	@mkdir -p $(@D) && touch $@

# Programs of other people that read what pm-render writes; only tests use them (tests/cli/exports.bats).
PYTHON_PACKAGES := numpy usd-core plyfile gsply zstandard
.PHONY: test-python
test-python: build/test/python/.installed ## Install the Python packages that tests of exported files use
build/test/python/.installed:
	python3 -m venv $(@D)
	$(@D)/bin/pip install --quiet --disable-pip-version-check $(PYTHON_PACKAGES)
	@touch $@

# --- Runs ---------------------------------------------------------------------------------------------------------

BUILT_TOOLS := $(TOOLS:%=$(BIN)/%)
SAME_MAKE :=
# What a run may be given beside its own variables, because it builds the tools.
BUILD_VARIABLES := CXX CPPFLAGS CXXFLAGS EXTRA_CXXFLAGS LDFLAGS LDLIBS ARCH MARCH OPT PLAIN_OPT SAN BUILD V TOGETHER PRECOMPILE WERROR NVCC CUDA CUDA_ARCH
include pipelines/runs.mk
ifneq ($(filter pictures,$(MAKECMDGOALS)),)
  include docs/pictures.mk
endif

.PHONY: demo run preview audit batch batch-status evaluate evaluate-register pictures
demo: run-finished ## Install, build, run the example EXAMPLE=cake end to end, say where the video is
run: run-finished ## Run your own file: GAUSSIANS=scene.ply PROMPT="..." [UP=z] [RUN=runs/name] [SET="key=value ..."]
preview: run-previewed ## See before you wait: views, parts, plan and materials of a run on a page, with its variables: [OPEN=1]
audit: run-audited ## Compare a finished run with what its records name: [RUN=runs/demo]
evaluate: evaluate-finished ## Run the registered benchmark and print its tables: [CASES="cake lamp"] [EVALUATE=runs/evaluate]
evaluate-register: $(BIN)/pm-eval ## Register the benchmark's files as they are now, in examples/suite.sha256
	@$(BIN)/pm-eval suite --suite $(or $(SUITE),examples/suite.json) --register
pictures: pictures-finished ## Make the moving pictures of the docs again: [GUITAR=guitar.compressed.ply]
batch: batch-finished ## Run many scenes and write one table: SCENES="cake my/scene.json ..." or SCENES=list.txt
batch-status: batch-shown ## What of a batch runs where, and the time left: [BATCH=runs/batch] [EVERY=2]

# --- Tests --------------------------------------------------------------------------------------------------------

.PHONY: test test-unit test-cli
test: test-unit test-fuzz test-cli ## Run every test (SAN=1 for sanitizers)

# Real model servers from PyPI, which take minutes to install: not a part of `make test`. SERVERS is where they are kept.
SERVERS ?= $(BUILD)/servers
.PHONY: test-servers
test-servers: all $(TEST_TOOLS) ## Talk to real model servers (Triton, KServe, MLServer, llama.cpp, transformers), which it installs into build/servers
	@bash tests/servers/install.sh $(abspath $(SERVERS))
	@PM_SERVERS=$(abspath $(SERVERS)) PM_BIN=$(abspath $(BIN)) bats --tap $(sort $(wildcard tests/servers/*.bats))

# So that CI compiles in parallel and tests one after the other.
.PHONY: test-programs
test-programs: all $(BUILD)/test/unit $(TEST_TOOLS) $(FAILING_CALLS) $$(patsubst %,$(BUILD)/test/fuzz/%,$$(FUZZ_TARGETS))

# The solver's kernels depend on the width of the registers; most machines that build it know one width only.
NARROWER := $(if $(filter x86_64,$(shell uname -m)),x86-64-v3 x86-64)
.PHONY: check-portable
check-portable: $(BUILD)/gen/embedded_texts.cpp ## Compile the solver for processors without AVX-512 as well, without keeping it
	$(Q)for arch in $(NARROWER); do \
	  $(CXX) $(CPPFLAGS) $(CXXFLAGS) -march=$$arch -Wno-psabi -fsyntax-only $(KERNELS) || exit; \
	  echo "$(KERNELS) compile for $$arch"; done

# The solver's laws for a GPU: tests/cuda/laws.cu compares them with plain numbers where there is one. And every kernel, for all
# cards that a package would be built for, without keeping them.
ALL_CARDS := 75 80 86 89 90 100 120
.PHONY: check-cuda check-cuda-all
check-cuda: $(if $(NVCC),$(BUILD)/test/cuda/laws) ## Compile the solver's laws for a GPU where nvcc is found, and run them where a GPU is
	$(Q)$(if $(NVCC),$<,echo 'nvcc not found: the laws are not compiled for a GPU, skipped')
$(BUILD)/test/cuda/laws: tests/cuda/laws.cu tests/cuda/laws.h $(wildcard lib/mpm/math/*.h lib/mpm/material/*.h)
	@mkdir -p $(@D)
	$(call say,NVCC,$<)
	$(Q)$(NVCC) -std=c++17 -O2 -Ilib -Itests --Werror all-warnings $< -o $@
check-cuda-all: ## Compile the solver's kernels for all cards where nvcc is found, without keeping them: [CUDA_ARCH="75 90"]
	$(Q)$(if $(NVCC),object=$$(mktemp); known=" $$($(NVCC) --list-gpu-code | tr '\n' ' ') "; codes=; named=; \
	  for a in $(or $(CUDA_ARCH),$(ALL_CARDS)); do \
	    case "$$known" in (*" sm_$$a "*) codes="$$codes -gencode arch=compute_$$a$(,)code=sm_$$a"; named="$$named $$a";; (*) echo "this nvcc knows no sm_$$a: left out";; esac; done; \
	  status=0; $(NVCC) $(CUDA_FLAGS) --threads 0 $$codes -c $(CUDA_SOURCES) -o $$object && echo "$(CUDA_SOURCES) compiles for$$named" || status=$$?; \
	  rm -f $$object; exit $$status,echo 'nvcc not found: the kernels are not compiled$(,) skipped')

# What the kernels compute, without a GPU in an emulator of blocks and threads: a small part of it is in `make test`.
.PHONY: test-emulator test-gpu bench-gpu
test-emulator: $(BUILD)/test/unit ## The solver's GPU kernels in an emulator, with SCALE=4 times the particles of `make test`
	@PM_SCALE=$(or $(SCALE),4) $(BUILD)/test/unit -tc="mpm gpu*" -d
# The same tests on the card, and its speed beside the CPU's. tests/gpu/check.sh does it all on a machine with nothing but nvcc.
test-gpu: $(BUILD)/test/unit ## The solver's tests on this machine's GPU
	@PM_GPU=1 $(BUILD)/test/unit -tc="mpm gpu*" -d
bench-gpu: $(BUILD)/bench/gpu ## Speed of the solver on this machine's GPU beside its CPU
	@$<
$(BUILD)/bench/gpu: $(BUILD)/obj/tests/gpu/bench.o $(LIBRARIES)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

ifeq ($(SAN),1)
export LSAN_OPTIONS := suppressions=$(abspath tests/leaks.supp):print_suppressions=0
endif

test-unit: $(BUILD)/test/unit ## The C++ tests
	@$(BUILD)/test/unit

# bats prints TAP; the closing line sums it up.
test-cli: all $(TEST_TOOLS) $(FAILING_CALLS) ## The command-line tests
	@log=$$(mktemp); PM_BIN=$(abspath $(BIN)) PM_SAN=$(SAN) bats --tap $(sort $(wildcard tests/cli/*.bats)) | tee $$log; \
	status=$${PIPESTATUS[0]}; passed=$$(grep -c '^ok' $$log); skipped=$$(grep -c '^ok.* # skip' $$log); failed=$$(grep -c '^not ok' $$log); \
	rm -f $$log; echo "$$((passed - skipped)) passed, $$failed failed, $$skipped skipped"; exit $$status

# --- Fuzzing ------------------------------------------------------------------------------------------------------

# Every reader of foreign or authored files has a target in tests/fuzz. With clang++ libFuzzer drives them; without it
# tests/fuzz/driver.cpp does, which mutates without looking at coverage. Both with the sanitizers. `make test` replays
# the corpus.
# What slows them down is off: libFuzzer's weights of inputs, names of new functions, and stacks of allocations, which a
# replay of what was found shows.
FUZZ_TARGETS := $(filter-out driver,$(patsubst tests/fuzz/%.cpp,%,$(wildcard tests/fuzz/*.cpp)))
SECONDS_EACH = $(or $(SECONDS),60)
FUZZ_CLANG := $(shell command -v clang++ 2>/dev/null)
FUZZ_CXX ?= $(or $(FUZZ_CLANG),$(CXX))
FUZZ_ENGINE := $(if $(findstring clang,$(FUZZ_CXX)),libfuzzer,driver)
FUZZ_BUILD := build/fuzz/$(FUZZ_ENGINE)
FUZZ_FLAGS := -std=c++17 -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined -w \
              $(if $(filter libfuzzer,$(FUZZ_ENGINE)),-fsanitize=fuzzer-no-link)
# What the targets reach: all but the command line, the making of scenes, the segmenter and the renderer.
FUZZ_SOURCES := $(filter-out lib/base/command_line.cpp lib/base/team.cpp lib/remote/remote_flags.cpp $(patsubst %,lib/scene/%.cpp,color placement), \
                  $(wildcard $(patsubst %,lib/%/*.cpp,base records scene remote plan))) \
                $(patsubst %,lib/bundle/%.cpp,captured_views choose_views colmap_model dataparser_transform dense_component distortion foreign_json \
                  material_files physgaussian physgaussian_boundaries pose_lists selection transforms_json usda_points view_rig) \
                $(patsubst %,lib/masks/%.cpp,coco mask_doubts mask_models queries) \
                $(patsubst %,lib/material/%.cpp,chat_source pictures predictor_source) lib/screen/run_table.cpp \
                $(patsubst %,lib/metrics/%.cpp,clip clip_tokenizer video_tracks) lib/tables/suite.cpp \
                lib/splat/video_reader.cpp
FUZZ_OBJECTS := $(FUZZ_SOURCES:%.cpp=$(FUZZ_BUILD)/obj/%.o) $(FUZZ_BUILD)/obj/embedded_texts.o

$(FUZZ_BUILD)/obj/%.o: %.cpp | build/.packages
	@mkdir -p $(@D)
	$(call say,FUZZ,$<)
	$(Q)$(FUZZ_CXX) $(CPPFLAGS) $(FUZZ_FLAGS) -MMD -MP -c $< -o $@
$(FUZZ_BUILD)/obj/embedded_texts.o: $(BUILD)/gen/embedded_texts.cpp
	@mkdir -p $(@D)
	$(Q)$(FUZZ_CXX) $(CPPFLAGS) $(FUZZ_FLAGS) -c $< -o $@
$(FUZZ_TARGETS:%=$(FUZZ_BUILD)/%): $(FUZZ_BUILD)/%: $(FUZZ_BUILD)/obj/tests/fuzz/%.o $(FUZZ_OBJECTS) \
    $(if $(filter driver,$(FUZZ_ENGINE)),$(FUZZ_BUILD)/obj/tests/fuzz/driver.o)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CXX) -fsanitize=address,undefined $(if $(filter libfuzzer,$(FUZZ_ENGINE)),-fsanitize=fuzzer) $^ $(LDLIBS) -o $@
-include $(wildcard $(FUZZ_BUILD)/obj/*/*/*.d)

.PHONY: fuzz fuzz-seeds test-fuzz
fuzz: $(FUZZ_TARGETS:%=$(FUZZ_BUILD)/%) ## Fuzz every reader for SECONDS=60 each; FUZZ="gaussians colmap" picks targets
	$(Q)cd $(FUZZ_BUILD) && for t in $(or $(FUZZ),$(FUZZ_TARGETS)); do \
	  mkdir -p found/$$t; echo "$$t: $(SECONDS_EACH) s with $(FUZZ_ENGINE)"; \
	  $(if $(filter libfuzzer,$(FUZZ_ENGINE)),ASAN_OPTIONS=malloc_context_size=0 ./$$t -max_total_time=$(SECONDS_EACH) -timeout=10 -rss_limit_mb=2048 -verbosity=0 \
	    -entropic=0 -print_funcs=0 -print_final_stats=1 found/$$t $(CURDIR)/tests/fuzz/corpus/$$t > found/$$t.log 2>&1; status=$$?; \
	    grep -aE '^(stat::|fault:|SUMMARY|.*ERROR:|.*Test unit written)' found/$$t.log; [ $$status -eq 0 ], \
	    ./$$t -max_total_time=$(SECONDS_EACH) $(CURDIR)/tests/fuzz/corpus/$$t) || exit; done

fuzz-seeds: $(BUILD)/test/make_fuzz_seeds all ## Write the seeds of tests/fuzz/corpus again
	$(Q)$< tests/fuzz/corpus && tests/fuzz/record-seeds.sh $(BIN) tests/fuzz/corpus/records

# The corpus, with this build's own flags (SAN=1 for the sanitizers), once.
$(FUZZ_TARGETS:%=$(BUILD)/test/fuzz/%): $(BUILD)/test/fuzz/%: $(BUILD)/obj/tests/fuzz/%.o $(BUILD)/obj/tests/fuzz/driver.o $(LIBRARIES)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

test-fuzz: $(FUZZ_TARGETS:%=$(BUILD)/test/fuzz/%) ## Replay the fuzzing corpus
	@for t in $(FUZZ_TARGETS); do printf '%s: ' $$t; $(BUILD)/test/fuzz/$$t tests/fuzz/corpus/$$t || exit; done

# --- Attacks ------------------------------------------------------------------------------------------------------

# What docs/security.md promises, tried: kills, mutated files, injections, changed files, hostile servers, and faults of system
# calls. KILLS=20 MUTATIONS=2000 INJECTIONS=some takes a few minutes.
HARDENING ?= runs/hardening
KILLS ?= 300
MUTATIONS ?= 100000
INJECTIONS ?= all
# Not by $(MAKE) in the recipe, which make -n would run.
this_make := $(MAKE) --no-print-directory BUILD=$(BUILD) SAN=$(SAN)
.PHONY: hardening
hardening: all $(TEST_TOOLS) $(FUZZ_TARGETS:%=$(BUILD)/test/fuzz/%) ## Attack the tools in every known way and print a table: [KILLS=300] [MUTATIONS=100000]
	@tests/hardening/hardening.sh $(BUILD) $(HARDENING) $(KILLS) $(MUTATIONS) $(INJECTIONS) "$(this_make) hardening-faults"

# Every open, write, sync, rename, close and thread of every tool fails once, and 100 allocations of each. `make test` takes
# a sample.
.PHONY: hardening-faults
hardening-faults: all $(FAILING_CALLS) ## Let every call of the system fail in turn, in every tool
	$(Q)tests/faults/walk.py $(BIN) $(FAILING_CALLS)

# On a real Slurm of four virtual nodes (slurm-wlm, munge), with 50 kills of make, srun, nodes and slurmctld. `make test` has the
# single cases.
.PHONY: hardening-cluster
hardening-cluster: all ## Kill a batch on a cluster at random moments and print a table: [KILLS=50]
	$(Q)tests/hardening/cluster_storm.py $(BIN) $(HARDENING)/cluster 20 $(if $(filter file,$(origin KILLS)),50,$(KILLS))

# --- Benchmarks ---------------------------------------------------------------------------------------------------

.PHONY: bench
bench: $(BENCH_SOURCES:tests/bench/%.cpp=$(BUILD)/bench/%) ## Speed of the solver, the renderer and lifting
	$(Q)for b in $^; do $$b || exit; done

# A page of pm-render --html in a headless Chromium, which draws in software; of a run in RUN that was accepted, unless VIEWER= names one.
VIEWER ?=
.PHONY: viewer-speed
viewer-speed: $(if $(VIEWER),,$(BIN)/pm-render) ## Milliseconds a frame of the 3D viewer in a headless Chromium: [VIEWER=page.html] [RUN=runs/demo]
	$(Q)$(if $(VIEWER),,run=$(or $(RUN),runs/demo); id=$$(sed -n 's/^  "candidate": "\(.*\)",/\1/p' $$run/accepted.json) && [ -n "$$id" ] && \
	  $(BIN)/pm-render --scene $$run/spec/render.json --state $$run/state.h5 --rollout $$run/rollouts/$$id.h5 --out $(BUILD)/viewer-speed.mp4 --html $(BUILD)/viewer-speed.html --quiet && \
	)python3 tests/tools/viewer_speed.py $(or $(VIEWER),$(BUILD)/viewer-speed.html)

# --- Studies of the solver ----------------------------------------------------------------------------------------

.PHONY: stability
stability: $(BIN)/pm-eval ## Sweep the solver over stiff and extreme input: table, CSV and heat maps in STABILITY=runs/stability
	$(Q)$(BIN)/pm-eval stability --out $(or $(STABILITY),runs/stability) $(if $(THREADS),--threads $(THREADS))

$(BUILD)/bench/%: $(BUILD)/obj/tests/bench/%.o $(LIBRARIES)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

# --- Numerics -----------------------------------------------------------------------------------------------------

# Measure on a quiet machine; `make accuracy DOCS=1` also puts the plots of docs/numerics.md in their place.
ACCURACY ?= runs/accuracy
.PHONY: accuracy verification error-study stiff
accuracy: $(BIN)/pm-eval ## Error of the solver against run time: JSON, CSV and plots in runs/accuracy: [DEVICE=cuda]
	$(Q)$(BIN)/pm-eval accuracy --out $(ACCURACY) $(if $(DEVICE),--device $(DEVICE))
	$(if $(DOCS),$(Q)cp $(ACCURACY)/accuracy-position.png $(ACCURACY)/accuracy-strain.png $(ACCURACY)/accuracy-energy.png docs/images/)

stiff: $(BIN)/pm-eval ## Rows too stiff for the step, rigid against resolved: table, and runs/stiff.json; [YOUNGS_MODULUS=1.7e10]
	$(Q)$(BIN)/pm-eval stiff --out runs/stiff.json $(if $(YOUNGS_MODULUS),--youngs-modulus $(YOUNGS_MODULUS))

verification: $(BIN)/pm-eval ## The solver against analytic answers, under refinement
	$(Q)$(BIN)/pm-eval verification --out runs/verification.json

error-study: $(BIN)/pm-eval ## Estimated against true discretisation errors of fifteen cases
	$(Q)$(BIN)/pm-eval error-study --out runs/error-study.json

# --- Installation and packages ------------------------------------------------------------------------------------

include packaging/install.mk packaging/deb.mk

# --- Schemas ------------------------------------------------------------------------------------------------------

.PHONY: schemas
schemas: $(BUILD)/test/write_schemas ## Write the schemas that stem from lists of fields again
	$(Q)$< schemas

# --- Housekeeping -------------------------------------------------------------------------------------------------

# What is made in a folder of builds; it may hold other things.
MADE := bin obj gen precompiled test bench share libphysmas.a libphysmas-eval.a manifest cuda-arch
.PHONY: clean format help
clean: ## Remove build/, or BUILD (runs/ stays)
	rm -rf -- $(if $(filter build,$(BUILD)),build,$(MADE:%=$(BUILD)/%))
	$(Q)[ ! -d $(BUILD) ] || rmdir --ignore-fail-on-non-empty -- $(BUILD)

format: ## Format the sources with clang-format
	clang-format -i $(shell git ls-files "*.h" "*.cpp")

help: ## List the targets
	@echo 'Usage: make [target] [NAME=value ...]'
	@grep -hE '^[a-z-]+:.*##' Makefile packaging/*.mk | awk -F ':.*## ' '{ printf "  %-10s %s\n", $$1, $$2 }'
	@echo 'Variables: CXX, ARCH=native (or baseline: any processor), SAN=1 (sanitizers), BUILD=build, V=1 (print commands), PREFIX, THREADS, DEVICE, CUDA_ARCH'
