# PhysMAS outside its tree: runs from any folder with tools that are installed.
#
#   make -f PREFIX/share/physmas/physmas.mk run GAUSSIANS=scene.ply PROMPT="the guitar falls onto the floor"
#
# Runs go to runs/ of the folder that make is called in. `help` lists the goals; physmas.mk, batch.mk and evaluate.mk in
# pipelines/ say which variables they have. Installed as share/physmas/physmas.mk with pipelines/ and examples/ beside it;
# in the tree it works where it lies, with the tools that have been built.

SHELL := /bin/bash
.SHELLFLAGS := -o pipefail -c
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-builtin-rules --no-builtin-variables

THIS_FILE := $(realpath $(lastword $(MAKEFILE_LIST)))
ifeq ($(THIS_FILE),)
  $(error $(MAKEFILE_LIST): GNU Make cannot work with a folder whose name has spaces)
endif

include $(firstword $(wildcard $(addprefix $(dir $(THIS_FILE)),literal.mk pipelines/literal.mk)))
ifeq ($(call is_plain,$(THIS_FILE)),)
  $(error $(call said,$(THIS_FILE)): GNU Make cannot work with a folder whose name has one of $(strip $(special)))
endif

# BIN=folder, else the tools of the same tree or prefix, else those on PATH.
BIN := $(abspath $(dir $(firstword $(wildcard $(patsubst %,$(dir $(THIS_FILE))%/pm-scene,../build/bin ../../bin)) \
         $(shell command -v pm-scene 2>/dev/null))))
ifeq ($(wildcard $(BIN)/pm-scene),)
  $(error The tools (pm-scene, ...) are not $(if $(BIN),in $(BIN),on PATH): BIN=folder says where they are)
endif
BUILT_TOOLS :=
SAME_MAKE := -f $(THIS_FILE)

.DEFAULT_GOAL := help
include $(firstword $(wildcard $(addprefix $(dir $(THIS_FILE)),runs.mk pipelines/runs.mk)))

.PHONY: demo run preview audit batch batch-status evaluate help
demo: run-finished ## Run the example EXAMPLE=cake end to end, say where the video is
run: run-finished ## Run your own file: GAUSSIANS=scene.ply PROMPT="..." [UP=z] [RUN=runs/name] [SET="key=value ..."]
preview: run-previewed ## See before you wait: views, parts, plan and materials of a run on a page, with its variables: [OPEN=1]
audit: run-audited ## Compare a finished run with what its records name: [RUN=runs/demo]
evaluate: evaluate-finished ## Run the registered benchmark and print its tables: [CASES="cake lamp"] [EVALUATE=runs/evaluate]
batch: batch-finished ## Run many scenes and write one table: SCENES="cake my/scene.json ..." or SCENES=list.txt
batch-status: batch-shown ## What of a batch runs where, and the time left: [BATCH=runs/batch] [EVERY=2]

help: ## List the goals
	@echo 'Usage: make $(SAME_MAKE) goal [NAME=value ...]'
	@sed -nE 's/^([a-z-]+):.* ## (.*)/\1\t\2/p' $(THIS_FILE) | awk -F '\t' '{ printf "  %-10s %s\n", $$1, $$2 }'
	@echo 'Variables: THREADS, EXECUTOR, BIN=$(BIN)'
