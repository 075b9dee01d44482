# The goals run, demo, audit, batch, batch-status and evaluate: their variables, and what physmas.mk, batch.mk and evaluate.mk share. Included
# by the Makefile and by installed.mk, which say:
#
# BIN          the folder of the tools
# BUILT_TOOLS  those that make can build, as files; empty outside the tree
# SAME_MAKE    the options that make needs to read the same makefile again, where it is not called Makefile
# BUILD_VARIABLES  the variables that building the tools has

# Relative in the tree, where records hold these paths.
PIPELINES := $(dir $(lastword $(MAKEFILE_LIST)))
EXAMPLES := $(PIPELINES:%pipelines/=%)examples/

EXAMPLE ?=
GAUSSIANS ?=
SCENE ?=

# --- Tools and executor -------------------------------------------------------------------------------------------

# What a run needs; pm-eval only where its error is asked for.
RUN_TOOLS := pm-scene pm-ground pm-lift pm-material pm-candidates pm-simulate pm-render pm-screen pm-report $(if $(ERROR),pm-eval)
# $(call built,TOOLS): what a rule that runs TOOLS waits for.
built = $(filter $(1:%=$(BIN)/%),$(BUILT_TOOLS))

ifneq ($(filter demo run preview batch batch-status evaluate audit,$(MAKECMDGOALS)),)
  EXECUTOR ?= local
  EXECUTORS := $(sort $(patsubst $(PIPELINES)executors/%.mk,%,$(wildcard $(PIPELINES)executors/*.mk)))
  EXECUTOR_FILE := $(if $(filter %.mk,$(EXECUTOR)),$(wildcard $(EXECUTOR)), \
                     $(patsubst %,$(PIPELINES)executors/%.mk,$(filter $(EXECUTORS),$(EXECUTOR))))
  ifneq ($(words $(EXECUTOR)) $(words $(EXECUTOR_FILE)),1 1)
    $(error EXECUTOR=$(EXECUTOR) is not there; known are $(EXECUTORS), or name a file: EXECUTOR=folder/mine.mk)
  endif
  include $(EXECUTOR_FILE)
  include $(PIPELINES)variables.mk
endif
# What the job of a rule reads.
job_inputs = $(filter-out FORCE,$^)

# --- Request files ------------------------------------------------------------------------------------------------

# Not empty where make only tells (-n, -q, -t): then nothing is written.
DRY := $(filter n q t,$(foreach o,n q t,$(findstring $(o),$(filter-out -%,$(firstword $(MAKEFLAGS))))))

same_words = $(and $(findstring x$(strip $(1))x,x$(strip $(2))x),$(findstring x$(strip $(2))x,x$(strip $(1))x))
# $(eval $(call remember,FILE,TEXT)): FILE holds TEXT, something that was asked for, and is rewritten only when that changes:
# a rule that depends on FILE runs again when something else is asked for.
define remember
$(if $(DRY),,$(if $(wildcard $(1)),$(if $(call same_words,$(file <$(1)),$(2)),,$(file >$(1),$(2))),$(file >$(1),$(2))))
$(1): ;
endef

# --- Goals --------------------------------------------------------------------------------------------------------

ifneq ($(filter demo,$(MAKECMDGOALS)),)
  RUN ?= runs/demo$(patsubst %,-%,$(filter-out cake,$(EXAMPLE)))
  override EXAMPLE := $(or $(EXAMPLE),cake)
endif
ifneq ($(filter run preview,$(MAKECMDGOALS)),)
  # The run is called after the scene: "my scans/Stuhl (1).compressed.ply" -> runs/Stuhl-1.
  run_name = $(if $(call is_plain,$(1)),$(notdir $(1:%/=%)),$(shell basename -- $(quoted) | LC_ALL=C sed -E 's/[^[:alnum:]._-]+/-/g; s/-+(\.|$$)/\1/g; s/^-+//'))
  RUN ?= runs/$(or $(EXAMPLE),$(subst .compressed,,$(basename $(call run_name,$(or $(value GAUSSIANS),$(patsubst %/scene.json,%,$(value SCENE)))))),run)
  ifeq ($(EXAMPLE)$(value GAUSSIANS)$(value SCENE),)
    # The scene of an earlier run: its own bundle, or the one that it was made from (RUN/source, inputs.mk).
    earlier := $(wildcard $(RUN)/bundle/scene.json)
    ifeq ($(earlier),)
      earlier := $(if $(wildcard $(RUN)/source),$(shell sed -n '1s/^SCENE=//p' $(RUN)/source))
    endif
    ifeq ($(earlier),)
      $(error make $(firstword $(filter run preview,$(MAKECMDGOALS))) needs GAUSSIANS=file.ply PROMPT="...", EXAMPLE=name, SCENE=scene.json, or the RUN= of an earlier run)
    endif
    override SCENE := $(earlier)
  endif
endif
ifneq ($(filter demo run preview,$(MAKECMDGOALS)),)
  # The batch has others (batch.mk).
  FINISHED := run-finished
  ended = @exit $(1)
  sweep = bash $(PIPELINES)sweep.sh $(RUN)
  include $(PIPELINES)physmas.mk
endif
ifneq ($(filter batch,$(MAKECMDGOALS)),)
  include $(PIPELINES)batch.mk
endif
ifneq ($(filter batch-status,$(MAKECMDGOALS)),)
  BATCH ?= runs/batch
  .PHONY: batch-shown
  batch-shown:
	@bash $(PIPELINES)batch-status.sh $(BATCH) $(EVERY)
endif
ifneq ($(filter audit,$(MAKECMDGOALS)),)
  RUN ?= runs/demo
  .PHONY: run-audited
  run-audited: | $(call built,pm-screen)
	@$(call job,audit,1,$(RUN),,$(RUN)/audit.log) $(BIN)/pm-screen --audit $(RUN)
endif
ifneq ($(filter evaluate,$(MAKECMDGOALS)),)
  ifeq ($(DRY),)
    include $(PIPELINES)evaluate.mk
  else
    # Its cases and methods are known once pm-eval has read the suite, which writes files.
    evaluate-finished: ; @echo "pm-eval suite says what a benchmark runs"
  endif
endif
