# The goals run, demo, batch and evaluate: their variables, and what physmas.mk, batch.mk and evaluate.mk share. Included
# by the Makefile and by installed.mk, which say:
#
# BIN          the folder of the tools
# BUILT_TOOLS  those that make can build, as files; empty outside the tree
# SAME_MAKE    the options that make needs to read the same makefile again, where it is not called Makefile

# Relative in the tree, where records hold these paths.
PIPELINES := $(dir $(lastword $(MAKEFILE_LIST)))
EXAMPLES := $(PIPELINES:%pipelines/=%)examples/

EXAMPLE ?=
GAUSSIANS ?=
PROMPT ?=
UP ?=
SCENE ?=

# --- Tools and executor -------------------------------------------------------------------------------------------

# What a run needs; pm-eval is not among them.
RUN_TOOLS := pm-scene pm-ground pm-lift pm-material pm-candidates pm-simulate pm-render pm-screen
# $(call built,TOOLS): what a rule that runs TOOLS waits for.
built = $(filter $(1:%=$(BIN)/%),$(BUILT_TOOLS))

ifneq ($(filter demo run batch evaluate,$(MAKECMDGOALS)),)
  EXECUTOR ?= local
  EXECUTORS := $(sort $(patsubst $(PIPELINES)executors/%.mk,%,$(wildcard $(PIPELINES)executors/*.mk)))
  EXECUTOR_FILE := $(if $(filter %.mk,$(EXECUTOR)),$(wildcard $(EXECUTOR)), \
                     $(patsubst %,$(PIPELINES)executors/%.mk,$(filter $(EXECUTORS),$(EXECUTOR))))
  ifneq ($(words $(EXECUTOR)) $(words $(EXECUTOR_FILE)),1 1)
    $(error EXECUTOR=$(EXECUTOR) is not there; known are $(EXECUTORS), or name a file: EXECUTOR=folder/mine.mk)
  endif
  include $(EXECUTOR_FILE)
endif
# What the job of a rule reads.
job_inputs = $(filter-out FORCE,$^)

# --- Request files ------------------------------------------------------------------------------------------------

same_words = $(and $(findstring x$(strip $(1))x,x$(strip $(2))x),$(findstring x$(strip $(2))x,x$(strip $(1))x))
# $(eval $(call remember,FILE,TEXT)): FILE holds TEXT, something that was asked for, and is rewritten only when that changes:
# a rule that depends on FILE runs again when something else is asked for.
define remember
$(if $(wildcard $(1)),$(if $(call same_words,$(file <$(1)),$(2)),,$(file >$(1),$(2))),$(file >$(1),$(2)))
$(1): ;
endef

# --- Goals --------------------------------------------------------------------------------------------------------

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
  include $(PIPELINES)physmas.mk
endif
ifneq ($(filter batch,$(MAKECMDGOALS)),)
  include $(PIPELINES)batch.mk
endif
ifneq ($(filter evaluate,$(MAKECMDGOALS)),)
  include $(PIPELINES)evaluate.mk
endif
