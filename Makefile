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
            -Wall -Wextra -Wno-unknown-pragmas -Wno-maybe-uninitialized $(if $(WERROR),-Werror) $(EXTRA_CXXFLAGS)
, := ,
LDFLAGS := -fopenmp $(if $(filter 1,$(SAN)),-fsanitize=address$(,)undefined) -Wl,--as-needed
LDLIBS := -L/usr/lib/x86_64-linux-gnu/hdf5/serial -L/usr/lib/aarch64-linux-gnu/hdf5/serial -lhdf5 \
          -lopencv_video -lopencv_imgcodecs -lopencv_imgproc -lopencv_core \
          -lavformat -lavcodec -lswscale -lavutil -lcurl -lcrypto -lz -lfmt

LIB_SOURCES := $(wildcard lib/*/*.cpp)
TOOL_SOURCES := $(wildcard tools/*.cpp)
UNIT_SOURCES := $(wildcard tests/unit/*.cpp)
TEST_TOOL_SOURCES := $(wildcard tests/tools/*.cpp)
BENCH_SOURCES := $(wildcard tests/bench/*.cpp)
SCHEMAS := $(wildcard schemas/*.json)
PROMPTS := $(wildcard lib/*/prompts/*.txt)
PAGES := $(wildcard lib/*/pages/*.html)
TOOLS := $(TOOL_SOURCES:tools/%.cpp=%)
TEST_TOOLS := $(TEST_TOOL_SOURCES:tests/tools/%.cpp=$(BUILD)/test/%)
BIN := $(BUILD)/bin

objects = $(patsubst %.cpp,$(BUILD)/obj/%.o,$(1))
LIB_OBJECTS := $(call objects,$(LIB_SOURCES)) $(addprefix $(BUILD)/obj/gen/,schemas.o prompts.o pages.o)
LIBRARY := $(BUILD)/libphysmas.a

.PHONY: all
all: $(TOOLS:%=$(BIN)/%) ## Build the tools into build/bin (make -j2)

# The stages whose decisions are compared number by number: no contraction to fused multiply-adds, so that their results do
# not depend on the processor.
$(BUILD)/obj/lib/material/% $(BUILD)/obj/lib/candidate/% $(BUILD)/obj/lib/screen/%: CXXFLAGS += -ffp-contract=off

$(BUILD)/obj/%.o: %.cpp | build/.packages
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

# So do the prompts of the agents: lib/material/prompts/row.txt is "material/row".
$(BUILD)/gen/prompts.cpp: $(PROMPTS) Makefile
	@mkdir -p $(@D)
	@{ echo '// Generated from lib/*/prompts/*.txt by the Makefile.'; \
	   echo '#include "remote/prompt_text.h"'; \
	   echo 'namespace physmas::remote { const PromptText kPromptTexts[] = {'; \
	   for f in $(PROMPTS); do b=$${f#lib/}; b=$${b%.txt}; printf '{"%s", R"pmprompt(' "$${b/\/prompts/}"; cat "$$f"; echo ')pmprompt"},'; done; \
	   echo '}; const int kPromptTextCount = sizeof(kPromptTexts) / sizeof(kPromptTexts[0]); }'; } > $@

# And the pages that tools write: lib/eval/pages/study.html is "study".
$(BUILD)/gen/pages.cpp: $(PAGES) Makefile
	@mkdir -p $(@D)
	@{ echo '// Generated from lib/*/pages/*.html by the Makefile.'; \
	   echo '#include "eval/page_text.h"'; \
	   echo 'namespace physmas::eval { const PageText kPageTexts[] = {'; \
	   for f in $(PAGES); do b=$${f##*/}; printf '{"%s", R"pmpage(' "$${b%.html}"; cat "$$f"; echo ')pmpage"},'; done; \
	   echo '}; const int kPageTextCount = sizeof(kPageTexts) / sizeof(kPageTexts[0]); }'; } > $@

$(BUILD)/obj/gen/%.o: $(BUILD)/gen/%.cpp
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

# Programs that write fixtures for the command-line tests: tests/tools/NAME.cpp -> build/test/NAME.
$(TEST_TOOLS): $(BUILD)/test/%: $(BUILD)/obj/tests/tools/%.o $(LIBRARY)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

V ?= 0
Q := $(if $(filter 0,$(V)),@)
say = $(if $(filter 0,$(V)),@printf '  %-5s %s\n' '$(1)' '$(2)')

.PRECIOUS: $(BUILD)/obj/%.o
# A run reads this file several times (pipelines/physmas.mk); header dependencies matter the first time only.
ifeq ($(MAKE_RESTARTS),)
-include $(patsubst %.o,%.d,$(LIB_OBJECTS) $(call objects,$(TOOL_SOURCES) $(UNIT_SOURCES) $(TEST_TOOL_SOURCES) $(BENCH_SOURCES) \
            $(wildcard tests/fuzz/*.cpp)))
endif

# --- What a bare Debian 12 lacks: one list for people, make and CI ------------------------------------------------

PACKAGES := g++ make libeigen3-dev libhdf5-dev libopencv-core-dev libopencv-imgproc-dev \
            libopencv-imgcodecs-dev libopencv-video-dev zlib1g-dev libavcodec-dev \
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

# --- Runs ---------------------------------------------------------------------------------------------------------

EXAMPLE ?=
GAUSSIANS ?=
PROMPT ?=
UP ?=
SCENE ?=

ifneq ($(filter demo,$(MAKECMDGOALS)),)
  RUN ?= runs/demo
  EXAMPLE := $(or $(EXAMPLE),cake)
endif
ifneq ($(filter run,$(MAKECMDGOALS)),)
  # An import without a prompt is a mistake that is better told here than by a tool.
  ifneq ($(GAUSSIANS),)
    ifeq ($(strip $(value PROMPT)),)
      $(error make run GAUSSIANS=... also needs PROMPT="what should happen")
    endif
  endif
  RUN ?= runs/$(firstword $(EXAMPLE) $(subst .compressed,,$(basename $(notdir $(or $(GAUSSIANS),$(patsubst %/scene.json,%,$(SCENE)))))) run)
  ifeq ($(EXAMPLE)$(GAUSSIANS)$(SCENE),)
    ifeq ($(wildcard $(RUN)/bundle/scene.json),)
      $(error make run needs GAUSSIANS=file.ply PROMPT="...", EXAMPLE=name, SCENE=scene.json, or the RUN= of an earlier run)
    endif
    SCENE := $(RUN)/bundle/scene.json
  endif
endif
ifneq ($(filter demo run,$(MAKECMDGOALS)),)
  include pipelines/physmas.mk
endif
ifneq ($(filter batch,$(MAKECMDGOALS)),)
  include pipelines/batch.mk
endif

.PHONY: demo run batch
demo: run-finished ## Install, build, run the example EXAMPLE=cake end to end, say where the video is
run: run-finished ## Run your own file: GAUSSIANS=scene.ply PROMPT="..." [UP=z] [RUN=runs/name] [SET="key=value ..."]
batch: batch-finished ## Run many scenes and write one table: SCENES="cake my/scene.json ..." or SCENES=list.txt

# --- Tests --------------------------------------------------------------------------------------------------------

.PHONY: test test-unit test-cli
test: test-unit test-fuzz test-cli ## Run every test (SAN=1 for sanitizers)

# So that CI compiles in parallel and tests one after the other.
.PHONY: test-programs
test-programs: all $(BUILD)/test/unit $(TEST_TOOLS) $(FUZZ_TARGETS:%=$(BUILD)/test/fuzz/%)

test-unit: $(BUILD)/test/unit ## The C++ tests
	@$(BUILD)/test/unit

# bats prints TAP; the closing line sums it up.
test-cli: all $(TEST_TOOLS) ## The command-line tests
	@log=$$(mktemp); PM_BIN=$(abspath $(BIN)) PM_SAN=$(SAN) bats --tap $(sort $(wildcard tests/cli/*.bats)) | tee $$log; \
	status=$${PIPESTATUS[0]}; passed=$$(grep -c '^ok' $$log); skipped=$$(grep -c '^ok.* # skip' $$log); failed=$$(grep -c '^not ok' $$log); \
	rm -f $$log; echo "$$((passed - skipped)) passed, $$failed failed, $$skipped skipped"; exit $$status

# --- Fuzzing ------------------------------------------------------------------------------------------------------

# Every reader of foreign or authored files has a target in tests/fuzz. With clang++ libFuzzer drives them; without it
# tests/fuzz/driver.cpp does, which mutates without looking at coverage. Both with the sanitizers. `make test` replays
# the corpus.
FUZZ_TARGETS := $(filter-out driver,$(patsubst tests/fuzz/%.cpp,%,$(wildcard tests/fuzz/*.cpp)))
SECONDS_EACH = $(or $(SECONDS),60)
FUZZ_CLANG := $(shell command -v clang++ 2>/dev/null)
FUZZ_CXX ?= $(or $(FUZZ_CLANG),$(CXX))
FUZZ_ENGINE := $(if $(findstring clang,$(FUZZ_CXX)),libfuzzer,driver)
FUZZ_BUILD := build/fuzz/$(FUZZ_ENGINE)
FUZZ_FLAGS := -std=c++17 -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined -w \
              $(if $(filter libfuzzer,$(FUZZ_ENGINE)),-fsanitize=fuzzer-no-link)
# What the targets reach: all but the command line and the making of scenes.
FUZZ_SOURCES := $(filter-out lib/base/command_line.cpp $(patsubst %,lib/scene/%.cpp,color neighbors overrides pattern \
                  placement report surface synth),$(wildcard lib/base/*.cpp lib/records/*.cpp lib/scene/*.cpp)) \
                lib/ground/coco.cpp lib/eval/array_file.cpp lib/eval/zip_file.cpp lib/splat/image_io.cpp
FUZZ_OBJECTS := $(FUZZ_SOURCES:%.cpp=$(FUZZ_BUILD)/obj/%.o) $(FUZZ_BUILD)/obj/schemas.o

$(FUZZ_BUILD)/obj/%.o: %.cpp | build/.packages
	@mkdir -p $(@D)
	$(call say,FUZZ,$<)
	$(Q)$(FUZZ_CXX) $(CPPFLAGS) $(FUZZ_FLAGS) -MMD -MP -c $< -o $@
$(FUZZ_BUILD)/obj/schemas.o: $(BUILD)/gen/schemas.cpp
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
	  $(if $(filter libfuzzer,$(FUZZ_ENGINE)),./$$t -max_total_time=$(SECONDS_EACH) -timeout=10 -rss_limit_mb=2048 -verbosity=0 \
	    -print_final_stats=1 found/$$t $(CURDIR)/tests/fuzz/corpus/$$t 2>&1 | tail -8, \
	    ./$$t -max_total_time=$(SECONDS_EACH) $(CURDIR)/tests/fuzz/corpus/$$t) || exit; done

fuzz-seeds: $(BUILD)/test/make_fuzz_seeds all ## Write the seeds of tests/fuzz/corpus again
	$(Q)$< tests/fuzz/corpus && tests/fuzz/record-seeds.sh $(BIN) tests/fuzz/corpus/records

# The corpus, with this build's own flags (SAN=1 for the sanitizers), once.
$(FUZZ_TARGETS:%=$(BUILD)/test/fuzz/%): $(BUILD)/test/fuzz/%: $(BUILD)/obj/tests/fuzz/%.o $(BUILD)/obj/tests/fuzz/driver.o $(LIBRARY)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

test-fuzz: $(FUZZ_TARGETS:%=$(BUILD)/test/fuzz/%) ## Replay the fuzzing corpus
	@for t in $(FUZZ_TARGETS); do printf '%s: ' $$t; $(BUILD)/test/fuzz/$$t tests/fuzz/corpus/$$t || exit; done

# --- Benchmarks ---------------------------------------------------------------------------------------------------

.PHONY: bench
bench: $(BENCH_SOURCES:tests/bench/%.cpp=$(BUILD)/bench/%) ## Speed: particle-steps per second of the solver, milliseconds per frame of the renderer
	$(Q)for b in $^; do $$b || exit; done

# --- Studies of the solver ----------------------------------------------------------------------------------------

.PHONY: stability
stability: $(BIN)/pm-eval ## Sweep the solver over stiff and extreme input: table, CSV and heat maps in STABILITY=runs/stability
	$(Q)$(BIN)/pm-eval stability --out $(or $(STABILITY),runs/stability) $(if $(THREADS),--threads $(THREADS))

$(BUILD)/bench/%: $(BUILD)/obj/tests/bench/%.o $(LIBRARY)
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CXX) $(LDFLAGS) $^ $(LDLIBS) -o $@

# --- Numerics -----------------------------------------------------------------------------------------------------

# Measure on a quiet machine; `make accuracy DOCS=1` also puts the plots of docs/numerics.md in their place.
ACCURACY ?= runs/accuracy
.PHONY: accuracy verification
accuracy: $(BIN)/pm-eval ## Error of the solver against run time: JSON, CSV and plots in runs/accuracy
	$(Q)$(BIN)/pm-eval accuracy --out $(ACCURACY)
	$(if $(DOCS),$(Q)cp $(ACCURACY)/accuracy-position.png $(ACCURACY)/accuracy-strain.png $(ACCURACY)/accuracy-energy.png docs/images/)

verification: $(BIN)/pm-eval ## The solver against analytic answers, under refinement
	$(Q)$(BIN)/pm-eval verification --out runs/verification.json

# --- Housekeeping -------------------------------------------------------------------------------------------------

PREFIX ?= /usr/local
.PHONY: install clean format help
install: all ## Install the tools into PREFIX/bin
	install -d $(DESTDIR)$(PREFIX)/bin
	install $(TOOLS:%=$(BIN)/%) $(DESTDIR)$(PREFIX)/bin

clean: ## Remove build/ (runs/ stays)
	rm -rf build

format: ## Format the sources with clang-format
	clang-format -i lib/*/*.h lib/*/*.cpp tools/*.cpp $(wildcard tests/*/*.cpp)

help: ## List the targets
	@echo 'Usage: make [target] [NAME=value ...]'
	@grep -hE '^[a-z-]+:.*##' Makefile | awk -F ':.*## ' '{ printf "  %-10s %s\n", $$1, $$2 }'
	@echo 'Variables: CXX, ARCH=native, SAN=1 (sanitizers), BUILD=build, V=1 (print commands), PREFIX, THREADS'
