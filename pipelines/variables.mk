# The variables of `make run`, `demo`, `preview`, `audit`, `batch`, `batch-status` and `evaluate`, and what they name: no variable is ignored. One that nobody
# knows, that another excludes, or whose file is not there ends make in one line, before a folder is made. Included by
# runs.mk, which gives EXAMPLES and PIPELINES.

# Those that name a file, a folder, or either.
FILE_VARIABLES := SCENE SPEC INVENTORY PLAN DATAPARSER PHYSGAUSSIAN MATERIALS AUTHORED PREDICTOR HEADERS BODY
FOLDER_VARIABLES := MASKS VIEWS BASE
EITHER_VARIABLES := GAUSSIANS CAMERAS
# An executor's own (EXECUTOR_VARIABLES, executors/local.mk), and those that the build has.
CALL_VARIABLES := THREADS DEVICE EXECUTOR BIN $(EXECUTOR_VARIABLES) $(BUILD_VARIABLES)
# What a scene of a batch may have beside its source.
RUN_VARIABLES := THREADS $(IMPORT_VARIABLES) $(SCENE_VARIABLES)
KNOWN_VARIABLES := $(CALL_VARIABLES) \
  $(if $(filter run demo preview,$(MAKECMDGOALS)),RUN $(SOURCE_VARIABLES) $(IMPORT_VARIABLES) $(SCENE_VARIABLES)) \
  $(if $(filter audit,$(MAKECMDGOALS)),RUN) $(if $(filter preview,$(MAKECMDGOALS)),OPEN) \
  $(if $(filter batch,$(MAKECMDGOALS)),SCENES BATCH $(IMPORT_VARIABLES) $(SCENE_VARIABLES)) \
  $(if $(filter batch-status,$(MAKECMDGOALS)),BATCH EVERY) \
  $(if $(filter evaluate,$(MAKECMDGOALS)),SUITE CASES EVALUATE)

# --- Names --------------------------------------------------------------------------------------------------------

unknown := $(firstword $(filter-out $(KNOWN_VARIABLES),$(ASKED)))
ifneq ($(unknown),)
  nearest := $(shell bash $(PIPELINES)nearest-name.sh $(call quoted,$(unknown)) $(sort $(KNOWN_VARIABLES)))
  $(error make $(call said,$(MAKECMDGOALS)) has no variable $(unknown)$(nearest:%=; the nearest is %))
endif

given = $(strip $(foreach v,$(1),$(if $($(v)),$(v))))
# $(call refuse,WHY): ends make. A batch has another, for one scene.
refuse = $(error $(1))

# --- What they name -----------------------------------------------------------------------------------------------

DEFAULTS ?= render.camera=fit render.floor=shadow contact.objects=separate
$(call given_to_tools,$(SOURCE_VARIABLES) $(IMPORT_VARIABLES) $(SCENE_VARIABLES))

# Who may be recorded: replay:FOLDER.
REPLAYABLE := SCENE_AGENT PERCEPTION AGENT PREDICTOR
# $(call replay_folder,VARIABLE): nothing where it names none.
replay_folder = $(if $(filter replay:%,$(firstword $($(1)))),$(subst $(space)replay:,,$(space)$($(1))))
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
    $$(call refuse,$(1)=$$(call said,$$(value $(1))) is not there)
  endif
  ifeq ($$(filter $(2),$$(named)),)
    ifneq ($$(named),)
      $$(call refuse,$(1)=$$(call said,$$(value $(1))) is a $$(named)$$(,) expected a $(2))
    endif
  endif
endif
endef

ifneq ($(filter run demo preview batch,$(MAKECMDGOALS)),)
  check_sources := $(filter run demo preview,$(MAKECMDGOALS))
  include $(PIPELINES)scene-variables.mk
endif

# What make works in must be a name that it can hold, also where it is made from other names.
$(foreach v,$(call given,$(WORKING_FOLDERS)),$(if $(call is_plain,$($(v))),,$(error $(v)=$(call said,$($(v))): $(call about_folder,$(v),$($(v))))))

# A file's or folder's whole name, without . and .., also where it has spaces.
blank := <blank>
whole_name = $(subst $(blank),$(space),$(abspath $(subst $(space),$(blank),$(1))))
