# The scene of a run, from where it is to the bundle: what files and folders it is made from, and whose run this folder is.
# Included by physmas.mk.

# --- Names that make cannot hold ----------------------------------------------------------------------------------

# "my scans/Stuhl (1).ply" is no word for make. A link in RUN/inputs stands for it where make asks how old a file is; tools
# get the name itself (`option` in literal.mk).
# $(call in_make,VARIABLE): what the variable names, as make can hold it; nothing where it names nothing.
in_make = $(if $(call file_named,$(1)),$(if $(call is_plain,$(value $(1))),$(value $(1)),$(RUN)/inputs/$(1)))
NAMED := $(filter-out SCENE BASE,$(FILE_VARIABLES) $(FOLDER_VARIABLES) $(EITHER_VARIABLES))
$(foreach v,$(NAMED),$(eval in_make_$(v) := $$(call in_make,$(v))))
# A bundle is linked as a folder: its records name its files.
scene_words := $(subst $(space),$(blank),$(SCENE))
scene_folder := $(patsubst %/,%,$(dir $(scene_words)))
BUNDLE := $(if $(SCENE),$(if $(call is_plain,$(SCENE)),$(scene_folder),$(RUN)/inputs/SCENE),$(RUN)/bundle)
SCENE_FILE := $(BUNDLE)/$(if $(SCENE),$(notdir $(scene_words)),scene.json)
LINKS := $(filter $(RUN)/inputs/%,$(BUNDLE) $(foreach v,$(NAMED),$(in_make_$(v))))
export PM_SCENE_FILE := $(subst $(blank),$(space),$(SCENE_FILE))
linked_to = $(call whole_name,$(if $(filter %/SCENE,$(1)),$(subst $(blank),$(space),$(scene_folder)),$(value $(notdir $(1)))))

# --- Whose run this is --------------------------------------------------------------------------------------------

# One folder holds the runs of one scene, so that another file of the same name replaces nothing. A run that goes on from its
# own bundle keeps its source.
source_variable := $(firstword $(call given,$(SOURCE_VARIABLES)))
source_file := $(if $(EXAMPLE),,$(call whole_name,$(value $(source_variable))))
OWN_SCENE := $(if $(SCENE),$(call same_words,$(source_file),$(abspath $(RUN)/bundle/scene.json)))
ifeq ($(PHASE),0)
  ifeq ($(DRY),)
    ifneq ($(shell mkdir -p $(RUN)/inputs $(STAMPS) && $(sweep) && echo made),made)
      $(call refuse,$(RUN) cannot be made: is its folder writable?)
    endif
    ifneq ($(value before_run),)
      refusal := $(shell $(call before_run,$(RUN)) 2>&1)
      ifneq ($(refusal),)
        $(call refuse,$(call said,$(refusal)))
      endif
    endif
    ifeq ($(OWN_SCENE),)
      refusal := $(shell bash $(PIPELINES)claim-run.sh $(RUN) $(call quoted,$(source_variable)=$(or $(source_file),$(EXAMPLE))) $(call quoted,$(source_file)))
      ifneq ($(refusal),)
        $(call refuse,$(refusal))
      endif
    endif
    linked := $(foreach l,$(LINKS),$(shell ln -sfn -- $(call quoted,$(call linked_to,$(l))) $(l)))
  endif
endif
$(filter-out %/SCENE,$(LINKS)): ;

# --- What was asked for -------------------------------------------------------------------------------------------

# Rewritten only when it changes. A bundle that lies there is asked for nothing; what is changed of it, or of an example, is
# changed in the slices (physmas.mk).
REQUEST := $(foreach v,EXAMPLE GAUSSIANS $(if $(GAUSSIANS),PROMPT SPEC $(IMPORT_VARIABLES)),$(v)=$(value $(v))$(newline))
ifeq ($(SCENE),)
  $(eval $(call remember,$(RUN)/request,$(REQUEST)))
endif
$(eval $(call remember,$(RUN)/changes,$(foreach v,PROMPT SPEC,$(v)=$(if $(GAUSSIANS),,$(value $(v)))$(newline))))
# A folder of the user's is remembered by what lies in it: its files may have names that make cannot hold. Recorded exchanges are
# such a folder, and so is a bundle that lies somewhere; a run may lie in it.
folder_of_MASKS = $(MASKS)
folder_of_VIEWS = $(VIEWS)
$(foreach v,$(REPLAYABLE),$(eval folder_of_$(v) = $$(call replay_folder,$(v))))
folder_of_SCENE = $(BUNDLE)
run_inside = $(patsubst $(abspath $(BUNDLE))/%,./%/*,$(filter $(abspath $(BUNDLE))/%,$(abspath $(RUN))))
list_of = $(shell cd -- $(call quoted,$(call whole_name,$(folder_of_$(1)))) >/dev/null && \
  find -L . $(if $(filter SCENE,$(1)),-maxdepth 3 $(foreach f,$(run_inside),-not -path '$(f)')) -type f -printf '%P %s %T@\n' | LC_ALL=C sort | sha256sum)
list_file = $(if $(folder_of_$(1)),$(RUN)/inputs/$(1).list)
$(foreach v,$(REPLAYABLE),$(eval REPLAYED_$(v) := $$(call list_file,$(v))))
FOLDERS := $(foreach v,MASKS VIEWS,$(call list_file,$(v)))
LISTS := $(FOLDERS) $(foreach v,$(REPLAYABLE),$(REPLAYED_$(v))) $(if $(SCENE),$(RUN)/inputs/SCENE.list)
ifeq ($(PHASE),0)
  $(foreach l,$(LISTS),$(eval $(call remember,$(l),$(call list_of,$(basename $(notdir $(l)))))))
else
  $(LISTS): ;
endif

# --- The bundle ---------------------------------------------------------------------------------------------------

ifeq ($(SCENE),)
BUNDLE_FILES := $(sort $(BUNDLE)/scene.json $(call held,$(wildcard $(BUNDLE)/*.* $(BUNDLE)/*/*.* $(BUNDLE)/*/*/*.*)))

ifneq ($(EXAMPLE),)
$(STAMPS)/bundle: $(EXAMPLES)$(EXAMPLE).json $(RUN)/request $(call missing,$(BUNDLE)/scene.json) $(call promised,bundle) | $(call built,pm-scene)
	$(call stage,synth,$(BUNDLE))
	@$(explain) $(call job,$(@F),$(threads),$(job_inputs),$(BUNDLE)/scene.json,$@.log) \
	$(BIN)/pm-scene synth $< --out $(BUNDLE) --threads $(threads)
	$(call finish,$(BUNDLE)/*.* $(BUNDLE)/*/*.* $(BUNDLE)/*/*/*.* $(BUNDLE)/*/*/*/*.*)
else
$(STAMPS)/bundle: $(foreach v,GAUSSIANS SPEC INVENTORY PHYSGAUSSIAN MATERIALS CAMERAS DATAPARSER,$(in_make_$(v))) $(FOLDERS) $(RUN)/request \
                  $(call missing,$(BUNDLE)/scene.json) $(call promised,bundle) | $(call built,pm-scene)
	$(call stage,import,$(BUNDLE))
	@set -f; $(explain) $(call job,$(@F),$(threads),$(job_inputs) $(in_make_MASKS) $(in_make_VIEWS),$(BUNDLE)/scene.json,$@.log) \
	$(BIN)/pm-scene import --prompt="$$PM_ASKED_PROMPT" --out $(BUNDLE) \
	  $(call option,--up=,UP) $(call option,--front=,FRONT) $(call option,--inventory=,INVENTORY) $(call option,--masks=,MASKS) \
	  $(call option,--views=,VIEWS) $(call option,--cameras=,CAMERAS) $(call option,--dataparser-transforms=,DATAPARSER) \
	  $(call option,--run=,SPEC) $(call option,--physgaussian=,PHYSGAUSSIAN) $(call option,--materials=,MATERIALS) $(call option,--opacity-threshold=,OPACITY) \
	  $(if $(CROP),--crop $$PM_ASKED_CROP) $(READ:%=--read %) $(call option,--drop=,DROP) $(call option,--azimuth=,AZIMUTH) \
	  $(call option,--elevation=,ELEVATION) --threads $(threads) -- "$$PM_ASKED_GAUSSIANS"
	$(call finish,$(BUNDLE)/*.* $(BUNDLE)/*/*.* $(BUNDLE)/*/*/*.* $(BUNDLE)/*/*/*/*.*)
endif
$(BUNDLE_FILES): $(STAMPS)/bundle ;
else
BUNDLE_FILES := $(RUN)/inputs/SCENE.list
endif
