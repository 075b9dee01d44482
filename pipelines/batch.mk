# Many scenes, one call: make -j2 batch SCENES="cake ball-glass", or SCENES=list.txt. Included by runs.mk for the goal
# `batch`.
#
# SCENES   names of examples, scene.json files and files of Gaussians; or one text file of them, one per line, where variables of
#          `make run` may follow: guitar.ply UP=-y "PROMPT=the guitar falls"     (# starts a comment)
# BATCH    the folder, by default runs/batch: a run per scene in BATCH/NAME with its log.txt, table.tsv and index.html
# Variables that are given to make itself (SET, THREADS, ...) count for every scene.
#
# It is one graph: physmas.mk is read once for every scene, and the stages of all are targets of one make. Its rules name the run
# by variables that are the scene's own while its rules are read; a recipe finds them again by the folder of its target (`state`).
# A scene learns one fact with each restart, all of them beside each other: no scene is in its third round before all have
# ended their second. What goes wrong stays the scene's own: make goes on (-k), the scene is left out from the next restart on, and its
# row of the table says why. Scenes in whose files nothing has changed since they ended are not read at all (batch-settled.sh).

BATCH ?= runs/batch
BATCH_LIST := $(BATCH)/scenes.list
ifeq ($(MAKE_RESTARTS),)
  BATCH_NAMES := $(shell EXAMPLES=$(EXAMPLES) bash $(PIPELINES)batch-scenes.sh $(if $(DRY),/dev/null,$(BATCH_LIST)) $(call quoted,$(SCENES)) \
    $(call quoted,$(RUN_VARIABLES)) 2>&1)
  ifneq ($(.SHELLSTATUS),0)
    $(error $(BATCH_NAMES))
  endif
else
  BATCH_NAMES := $(file <$(BATCH)/.live/scenes)
endif

ifneq ($(DRY),)
.PHONY: batch-finished $(BATCH_NAMES:%=batch-scene-%)
$(BATCH_NAMES:%=batch-scene-%): batch-scene-%:
	@echo "make run of $* in $(BATCH)/$*"
batch-finished: $(BATCH_NAMES:%=batch-scene-%)
else

# --- What was asked for -------------------------------------------------------------------------------------------

# BATCH/NAME/VARIABLE: what it is for that scene.
OWN_VARIABLES := $(RUN_VARIABLES) $(SOURCE_VARIABLES)
$(foreach v,$(OWN_VARIABLES),$(eval for_all/$(v) := $$($(v))))
# The list as words: a tab ends one, and a blank in a value is none.
list_words := $(shell LC_ALL=C sed -e 's/</<less>/g; s/ /<blank>/g; s/\r/<return>/g; s/^/@/' $(BATCH_LIST))
word_value = $(subst <less>,<,$(subst <return>,,$(subst <blank>,$(space),$(1))))
own_name = $(firstword $(subst =, ,$(1)))
own_value = $(call word_value,$(patsubst $(own_name)=%,%,$(1)))
$(foreach w,$(list_words),$(if $(filter @%,$(w)),$(eval own_run := $(BATCH)/$(w:@%=%)),\
  $(eval own_variables/$(own_run) += $(call own_name,$(w)))$(eval $(own_run)/own/$(call own_name,$(w)) := $$(call own_value,$$(w)))))

# --- Which scenes there is something to do for --------------------------------------------------------------------

batch_script = bash $(PIPELINES)batch-$(1).sh
# What all scenes were asked for.
ASKED_FOR_ALL := $(foreach v,$(filter-out THREADS,$(OWN_VARIABLES)),$(v)=$(for_all/$(v))$(newline))
$(eval $(call remember,$(BATCH)/.asked,$(ASKED_FOR_ALL)))
$(BATCH_LIST): ;
ifeq ($(MAKE_RESTARTS),)
  SETTLED := $(shell $(call batch_script,settled) $(BATCH))
  LIVE := $(filter-out $(SETTLED),$(BATCH_NAMES))
  # Names go by a file: a program takes 128 KiB in one argument.
  begun := $(shell mkdir -p $(BATCH)/.live && echo begun)
  $(if $(begun),$(file >$(BATCH)/.live/scenes,$(subst $(space),$(newline),$(BATCH_NAMES)))$(file >$(BATCH)/.live/to-do,$(subst $(space),$(newline),$(LIVE))))
  begun := $(shell $(call batch_script,begin) $(BATCH) && echo begun)
  ifneq ($(begun),begun)
    $(error $(BATCH) cannot be written: is its folder writable?)
  endif
  ifneq ($(SETTLED),)
    $(info $(if $(LIVE),,Nothing to do: )$(words $(SETTLED)) of $(words $(BATCH_NAMES)) scenes are up to date)
  endif
else
  # Those that learned their fact.
  LIVE := $(foreach n,$(file <$(BATCH)/.live/to-do),$(if $(strip $(file <$(BATCH)/$(n)/.stamps/phase$(MAKE_RESTARTS).mk)),$(n)))
endif

# --- The graph ----------------------------------------------------------------------------------------------------

MAKEFLAGS += --keep-going
# What a scene's recipes print, and its tools, is in its log.
to_log = >>$(RUN)/log.txt 2>&1
$(eval executor_job = $(value job))
job = $(if $(filter %/.stamps,$(@D)),$(call batch_script,job) $(BATCH) $(RUN) $(1) )$(executor_job)
ended = @$(call batch_script,end) $(BATCH) $(RUN) $(1)
FINISHED = $(RUN)/.stamps/finished
LAST_STEP = $(FINISHED)
# All at once, by batch-begin.sh.
sweep = true

# Variables that recipes of physmas.mk have, and that differ between scenes.
STATE := $(OWN_VARIABLES) BUNDLE SLICES GROUNDED MATERIAL_INPUTS LAST_ROUND IDS BEST_CAMERAS NEXT \
  PM_SCENE_FILE $(foreach v,MASKS VIEWS,in_make_$(v))

# $(call scene_graph,NAME)
define scene_graph
override RUN := $(BATCH)/$(1)
REFUSED :=
NEXT :=
$(foreach v,$(OWN_VARIABLES),override $(v) := $$(if $$(filter $(v),$$(own_variables/$(BATCH)/$(1))),$$($(BATCH)/$(1)/own/$(v)),$$(for_all/$(v)))$(newline))
$$(foreach v,$$(own_variables/$$(RUN)),$$(if $$(strip $$(call complaint,$$(v))),$$(call refuse,$$(v)=$$(call said,$$($$(v))): $$(strip $$(call complaint,$$(v))))))
ifeq ($$(REFUSED),)
  check_sources := yes
  include $(PIPELINES)scene-variables.mk
endif
ifeq ($$(REFUSED),)
  include $(PIPELINES)physmas.mk
endif
$$(foreach v,$(STATE),$$(if $$($$(v)),$$(eval $$(RUN)/state/$$(v) := $$$$($$(v)))))
ifneq ($$(REFUSED),)
  refused := $$(shell $(call batch_script,refuse) $(BATCH) $$(RUN) $$(call quoted,$$(call said,$$(REFUSED))))
endif
endef
override refuse = $(if $(REFUSED),,$(eval REFUSED := $$(1)))
$(foreach n,$(LIVE),$(eval $(call scene_graph,$(n))))

# From here on they are those of the scene whose target is being made.
override RUN = $(patsubst %/.stamps/,%,$(dir $@))
$(foreach v,$(STATE),$(eval override $(v) = $$($$(RUN)/state/$(v))))
$(foreach v,$(SOURCE_VARIABLES) $(IMPORT_VARIABLES) $(SCENE_VARIABLES),$(eval export PM_ASKED_$(v) = $$($(v))))

# --- The table ----------------------------------------------------------------------------------------------------

.PHONY: batch-finished
batch-finished: | $(call built,pm-screen pm-report)
	@$(call job,table,1,$(BATCH_LIST),$(BATCH)/table.tsv $(BATCH)/index.html,$(BATCH)/table.log) \
	env BIN=$(BIN) $(call batch_script,table) $(BATCH)
	@column -t -s "$$(printf '\t')" $(BATCH)/table.tsv 2>/dev/null || cat $(BATCH)/table.tsv
	@echo "  page  $(BATCH)/index.html"
endif
