# The variables of `make run`, `demo`, `batch` and `evaluate`, and what they name: no variable is ignored. One that nobody
# knows, that another excludes, or whose file is not there ends make in one line, before a folder is made. Included by
# runs.mk, which gives EXAMPLES and PIPELINES.

# Where a scene comes from: one of these.
SOURCE_VARIABLES := EXAMPLE GAUSSIANS SCENE
# How a file of Gaussians is imported: examples and bundles have what these say.
IMPORT_VARIABLES := UP FRONT INVENTORY MASKS VIEWS CAMERAS DATAPARSER PHYSGAUSSIAN OPACITY CROP DROP AZIMUTH ELEVATION
# What is done with any scene.
SCENE_VARIABLES := PROMPT MATERIAL SPEC SET CAMERA DEFAULTS SCENE_AGENT PERCEPTION AGENT MODEL PREDICTOR AUTHORED BASE
# Those that name a file, a folder, or either.
FILE_VARIABLES := SCENE SPEC INVENTORY DATAPARSER PHYSGAUSSIAN AUTHORED PREDICTOR
FOLDER_VARIABLES := MASKS VIEWS BASE
EITHER_VARIABLES := GAUSSIANS CAMERAS
# An executor's own (EXECUTOR_VARIABLES, executors/local.mk), the shell's, and those that the build has.
CALL_VARIABLES := THREADS EXECUTOR BIN SHELL $(EXECUTOR_VARIABLES) $(BUILD_VARIABLES)
KNOWN_VARIABLES := $(CALL_VARIABLES) \
  $(if $(filter run demo,$(MAKECMDGOALS)),RUN $(SOURCE_VARIABLES) $(IMPORT_VARIABLES) $(SCENE_VARIABLES)) \
  $(if $(filter batch,$(MAKECMDGOALS)),SCENES BATCH $(IMPORT_VARIABLES) $(SCENE_VARIABLES)) \
  $(if $(filter evaluate,$(MAKECMDGOALS)),SUITE CASES EVALUATE)

empty :=
space := $(empty) $(empty)
define newline


endef
# $(call quoted,TEXT): one word of the shell.
quoted = '$(subst ','\'',$(1))'
# $(call said,TEXT): for a message of one line.
said = $(subst $(newline),$(space),$(1))

# --- Names --------------------------------------------------------------------------------------------------------

# An empty variable asks for nothing.
asked := $(strip $(foreach v,$(.VARIABLES),$(if $(filter command,$(origin $(v))),$(if $(value $(v)),$(v)))))
unknown := $(firstword $(filter-out $(KNOWN_VARIABLES),$(asked)))
ifneq ($(unknown),)
  nearest := $(shell bash $(PIPELINES)nearest-name.sh $(call quoted,$(unknown)) $(sort $(filter-out SHELL,$(KNOWN_VARIABLES))))
  $(error make $(MAKECMDGOALS) has no variable $(unknown)$(nearest:%=; the nearest is %))
endif

given = $(strip $(foreach v,$(1),$(if $(value $(v)),$(v))))
ifneq ($(filter run demo,$(MAKECMDGOALS)),)
  sources := $(call given,$(SOURCE_VARIABLES))
  ifneq ($(word 2,$(sources)),)
    $(error A run has one scene: give $(firstword $(sources)) or $(word 2,$(sources)), not both)
  endif
  ifneq ($(filter demo,$(MAKECMDGOALS)),)
    ifneq ($(filter-out EXAMPLE,$(sources)),)
      $(error make demo runs an example: make run $(sources)=... runs your own scene)
    endif
  endif
  ifeq ($(filter GAUSSIANS,$(sources)),)
    ifneq ($(call given,$(IMPORT_VARIABLES)),)
      $(error $(firstword $(call given,$(IMPORT_VARIABLES))) goes with GAUSSIANS=file: $(if $(filter EXAMPLE,$(sources)),an example,a bundle) has its own; PROMPT, SPEC and SET change a run of it)
    endif
  endif
  # An import without a prompt is a mistake that is better told here than by a tool.
  ifneq ($(filter GAUSSIANS,$(sources)),)
    ifeq ($(strip $(value PROMPT)),)
      $(error make run GAUSSIANS=... also needs PROMPT="what should happen")
    endif
  endif
  ifneq ($(value MODEL),)
    ifeq ($(call given,AGENT SCENE_AGENT),)
      $(error MODEL names a model of a chat server: it goes with AGENT=URL or SCENE_AGENT=URL)
    endif
  endif
endif

# --- What they name -----------------------------------------------------------------------------------------------

# As a user typed it, for tools; through the environment, so that neither make nor the shell reads a prompt or a name.
$(foreach v,$(SOURCE_VARIABLES) $(IMPORT_VARIABLES) $(filter-out SET,$(SCENE_VARIABLES)),$(eval export PM_ASKED_$(v) := $$(value $(v))))
# $(call option,FLAG,VARIABLE): the flag, with the space or = that ends it, and its value, where there is one.
option = $(if $(value $(2)),$(1)"$$PM_ASKED_$(2)")

# What make or a shell reads as something else than part of a name.
special := : % \# ; = * ? [ ] ( ) | & ' " ` \ ~ < > ! { } $$
# $(call is_plain,TEXT): TEXT is one word that make can hold as a file's name.
is_plain = $(and $(filter 1,$(words $(1))),$(if $(findstring $(space),$(1)),,y),$(if $(strip $(foreach c,$(special),$(findstring $(c),$(1)))),,y))

# What of PREDICTOR and DATAPARSER is no file.
file_named = $(if $(filter none replay:% http://% https://%,$(value $(1))),,$(value $(1)))
# $(call kind_of,NAME): file, folder, or nothing where nothing is there.
kind_of = $(if $(call is_plain,$(1)),$(if $(wildcard $(1)),$(if $(wildcard $(1)/.),folder,file)), \
            $(shell n=$(quoted); if [ -d "$$n" ]; then echo folder; elif [ -e "$$n" ]; then echo file; fi))
# $(call check_name,VARIABLE,KIND)
define check_name
ifneq ($$(call file_named,$(1)),)
  named := $$(strip $$(call kind_of,$$(call file_named,$(1))))
  ifeq ($$(named),)
    $$(error $(1)=$$(call said,$$(value $(1))) is not there)
  endif
  ifeq ($$(filter $(2),$$(named)),)
    $$(error $(1)=$$(call said,$$(value $(1))) is a $$(named), expected a $(2))
  endif
endif
endef

ifneq ($(filter run demo batch,$(MAKECMDGOALS)),)
ifeq ($(MAKE_RESTARTS),)
  $(foreach v,$(FILE_VARIABLES),$(eval $(call check_name,$(v),file)))
  $(foreach v,$(FOLDER_VARIABLES),$(eval $(call check_name,$(v),folder)))
  $(foreach v,$(EITHER_VARIABLES),$(eval $(call check_name,$(v),file folder)))
  ifneq ($(EXAMPLE),)
    ifeq ($(and $(call is_plain,$(value EXAMPLE)),$(wildcard $(EXAMPLES)$(EXAMPLE).json)),)
      example_names := $(notdir $(basename $(shell grep -l physmas/example/1 $(EXAMPLES)*.json)))
      nearest := $(shell bash $(PIPELINES)nearest-name.sh $(call quoted,$(value EXAMPLE)) $(example_names))
      $(error EXAMPLE=$(call said,$(value EXAMPLE)) is no example$(if $(nearest),; the nearest is $(nearest),: there are $(example_names)))
    endif
  endif
endif
endif

# $(call check_folder,VARIABLE): what make works in must be a name that it can hold.
check_folder = $(if $(call is_plain,$($(1))),,$(error $(1)=$(call said,$($(1))): GNU Make cannot work in a folder whose name has spaces or one \
  of $(strip $(special)): give another $(1)))
$(foreach v,$(call given,RUN BATCH EVALUATE BASE),$(call check_folder,$(v)))

# A file's or folder's whole name, without . and .., also where it has spaces.
blank := <blank>
whole_name = $(subst $(blank),$(space),$(abspath $(subst $(space),$(blank),$(1))))
