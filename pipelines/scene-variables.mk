# Whether the variables of one scene go together and name what is there: `refuse` says what does not. Included by variables.mk for
# the goals `run`, `demo` and `preview`, and by batch.mk for every scene.

# A batch's scenes have their sources in its list.
ifneq ($(check_sources),)
sources := $(call given,$(SOURCE_VARIABLES))
ifneq ($(word 2,$(sources)),)
  $(call refuse,A run has one scene: give $(firstword $(sources)) or $(word 2,$(sources))$(,) not both)
endif
ifneq ($(filter demo,$(MAKECMDGOALS)),)
  ifneq ($(filter-out EXAMPLE,$(sources)),)
    $(call refuse,make demo runs an example: make run $(sources)=... runs your own scene)
  endif
endif
ifeq ($(filter GAUSSIANS,$(sources)),)
  ifeq ($(sources)$(call given,VIEWS CAMERAS),VIEWS)
    $(call refuse,Photographs are no scene yet: train a splat from them$(,) for example with nerfstudio (splatfacto)$(,) gsplat$(,) Brush or Postshot$(,) and give its .ply as GAUSSIANS=)
  endif
  ifneq ($(call given,$(IMPORT_VARIABLES)),)
    $(call refuse,$(firstword $(call given,$(IMPORT_VARIABLES))) goes with GAUSSIANS=file: $(if $(filter EXAMPLE,$(sources)),an example,a bundle) has its own; PROMPT$(,) SPEC and SET change a run of it)
  endif
endif
# An import without a prompt is a mistake that is better told here than by a tool.
ifneq ($(filter GAUSSIANS,$(sources)),)
  ifeq ($(strip $(value PROMPT)),)
    $(call refuse,make run GAUSSIANS=... also needs PROMPT="what should happen")
  endif
endif
ifneq ($(value MODEL),)
  ifeq ($(call given,AGENT SCENE_AGENT),)
    $(call refuse,MODEL names a model of a chat server: it goes with AGENT=URL or SCENE_AGENT=URL)
  endif
endif
ifneq ($(value BODY),)
  ifeq ($(call given,AGENT SCENE_AGENT),)
    $(call refuse,BODY has fields of a request to a chat server: it goes with AGENT=URL or SCENE_AGENT=URL)
  endif
endif
ifneq ($(call given,$(SERVER_VARIABLES)),)
  ifeq ($(call given,AGENT SCENE_AGENT PERCEPTION PREDICTOR),)
    $(call refuse,$(firstword $(call given,$(SERVER_VARIABLES))) says how a model server is asked: it goes with AGENT=URL$(,) SCENE_AGENT=URL$(,) PERCEPTION=URL or PREDICTOR=URL)
  endif
endif
endif

ifneq ($(filter-out 1,$(ERROR)),)
  $(call refuse,ERROR: found "$(call said,$(value ERROR))"$(,) expected 1: estimate the discretisation error)
endif

ifeq ($(MAKE_RESTARTS),)
  $(foreach v,$(FILE_VARIABLES),$(eval $(call check_name,$(v),file)))
  $(foreach v,$(FOLDER_VARIABLES),$(eval $(call check_name,$(v),folder)))
  $(foreach v,$(REPLAYABLE),$(if $(call replay_folder,$(v)),$(if $(filter folder,$(call kind_of,$(call replay_folder,$(v)))),, \
    $(call refuse,$(v)=$(call said,$($(v))) is no folder of recorded exchanges))))
  $(foreach v,$(EITHER_VARIABLES),$(eval $(call check_name,$(v),file folder)))
  ifneq ($(EXAMPLE),)
    ifeq ($(and $(call is_plain,$(value EXAMPLE)),$(wildcard $(EXAMPLES)$(EXAMPLE).json)),)
      example_names := $(notdir $(basename $(shell grep -l physmas/example/1 $(EXAMPLES)*.json)))
      nearest := $(shell bash $(PIPELINES)nearest-name.sh $(call quoted,$(value EXAMPLE)) $(example_names))
      $(call refuse,EXAMPLE=$(call said,$(value EXAMPLE)) is no example$(if $(nearest),; the nearest is $(nearest),: there are $(example_names)))
    endif
  endif
endif
