# What a user gives make is text. GNU Make reads NAME=value, on its command line or in the environment, as a piece of makefile: it
# would run $(shell ...) in it wherever the variable is used, and hands it so to every program that it starts. Here the values
# become plain text before anything uses them. Those of TEXT_VARIABLES may hold what they like and reach a tool through the
# environment only (`given_to_tools`); all others stand in rules and commands, and are refused where make or a shell would read
# them as something else than words. Included by the Makefile and by installed.mk before all else.

# Where this file and its helpers lie.
LITERAL := $(dir $(lastword $(MAKEFILE_LIST)))

# Where a scene comes from: one of these.
SOURCE_VARIABLES := EXAMPLE GAUSSIANS SCENE
# How a file of Gaussians is imported: examples and bundles have what these say.
IMPORT_VARIABLES := UP FRONT INVENTORY MASKS VIEWS CAMERAS DATAPARSER PHYSGAUSSIAN MATERIALS OPACITY CROP READ DROP AZIMUTH ELEVATION
# How model servers are asked.
SERVER_VARIABLES := TIMEOUT BUDGET RETRIES HEADERS BODY TENSORS
# What is done with any scene.
SCENE_VARIABLES := PROMPT PLAN MATERIAL SPEC SET CAMERA DEFAULTS SCENE_AGENT PERCEPTION AGENT MODEL PREDICTOR AUTHORED BASE $(SERVER_VARIABLES) ERROR

TEXT_VARIABLES := $(filter-out EXAMPLE BASE ERROR READ,$(SOURCE_VARIABLES) $(IMPORT_VARIABLES) $(SCENE_VARIABLES)) SCENES DESTDIR PREFIX MAINTAINER
# One word each.
WORD_VARIABLES := EXAMPLE BASE ERROR RUN BATCH EVALUATE SUITE BIN BUILD THREADS DEVICE RESOURCES ARRAY PATIENCE EVERY V SAN TOGETHER PRECOMPILE ARCH MARCH WERROR CUDA SECONDS \
  PICTURES GUITAR VIEWER SCALE STABILITY ACCURACY DOCS HARDENING KILLS MUTATIONS INJECTIONS SERVERS
# Several names.
NAMES_VARIABLES := CASES FUZZ READ RETRY CUDA_ARCH
# Those that name a folder which make itself works in.
WORKING_FOLDERS := RUN BATCH EVALUATE BASE

# A program, a shell or more makefiles are no business of a value.
of_make := $(strip $(foreach v,$(.VARIABLES),$(if $(filter command,$(origin $(v))),$(filter SHELL .% MAKE% MFLAGS GNUMAKEFLAGS VPATH CURDIR,$(v)))))
ifneq ($(of_make),)
  $(error $(firstword $(of_make)) is GNU Make's own and cannot be given)
endif

# Without these nothing below says what it should.
missing_programs := $(shell for p in awk cat chmod cp cut dirname find grep head ln ls mkdir mv rm sed sort tail tr uname xargs; do command -v "$$p" >/dev/null || printf '%s ' "$$p"; done)
ifneq ($(missing_programs),)
  $(error $(missing_programs)not found on PATH: expected the ordinary programs of a Debian system in it, as in PATH=/usr/bin:/bin)
endif

empty :=
space := $(empty) $(empty)
define newline


endef
# The control characters but the line's end, one word each; \t, \v and \f end a word of make.
tab := $(empty)	$(empty)
control_characters := $(shell printf '\1 \2 \3 \4 \5 \6 \7 \10 \15 \16 \17 \20 \21 \22 \23 \24 \25 \26 \27 \30 \31 \32 \33 \34 \35 \36 \37 \177')
vertical := $(shell printf '\13')
feed := $(shell printf '\14')
# $(call quoted,TEXT): one word of the shell.
quoted = '$(subst ','\'',$(1))'
# $(call said,TEXT): for a message of one line, without what a terminal would obey.
said = $(call without,$(control_characters),$(subst $(feed),$(space),$(subst $(vertical),$(space),$(subst $(tab),$(space),$(subst $(newline),$(space),$(1))))))
without = $(if $(1),$(call without,$(wordlist 2,99,$(1)),$(subst $(firstword $(1)),?,$(2))),$(2))

# What a shell reads as something else than part of a word, and what else is none for make.
shell_special := ; * ? [ ] ( ) | & ' " ` \ ~ < > ! { } $$ \#
special := : % = $(shell_special)
holds_any = $(strip $(foreach c,$(1),$(findstring $(c),$(2))))
has_control = $(or $(findstring $(newline),$(1)),$(findstring $(tab),$(1)),$(findstring $(vertical),$(1)),$(findstring $(feed),$(1)),$(call holds_any,$(control_characters),$(1)))
# $(call is_plain,TEXT): TEXT is one word that make can hold as a file's name, and no option of a program.
is_plain = $(and $(filter 1,$(words $(1))),$(if $(or $(filter -%,$(1)),$(findstring $(space),$(1)),$(call has_control,$(1)),$(call holds_any,$(special),$(1))),,y))
# $(call are_words,TEXT): nothing of it means something to a shell.
are_words = $(if $(or $(call has_control,$(1)),$(call holds_any,$(shell_special),$(1))),,y)

# $(call held,NAMES): those that make can hold.
held = $(foreach n,$(1),$(if $(call is_plain,$(n)),$(n)))

# --- What was given -----------------------------------------------------------------------------------------------

GIVEN := $(foreach v,$(.VARIABLES),$(if $(filter command,$(origin $(v))),$(v)))
# A name that is none was made by an expansion.
unnamed := $(firstword $(call holds_any,$(special),$(GIVEN)))
ifneq ($(unnamed),)
  $(error A variable's name has $(unnamed): expected NAME=value)
endif
# With a value; an empty one asks for nothing.
ASKED := $(foreach v,$(GIVEN),$(if $(value $(v)),$(v)))
$(foreach v,$(GIVEN),$(eval override $(v) := $$(value $(v))))
FROM_ENVIRONMENT := $(foreach v,$(TEXT_VARIABLES) $(WORD_VARIABLES),$(if $(filter environment%,$(origin $(v))),$(v)))
$(foreach v,$(FROM_ENVIRONMENT),$(eval $(v) := $$(value $(v))))

# --- What cannot be held ------------------------------------------------------------------------------------------

# $(call complaint,NAME): why NAME may not hold what it holds; nothing where it may.
complaint = $(call complaint_about,$(1),$(value $(1)))
complaint_about = $(or $(if $(filter $(1),$(TEXT_VARIABLES)),$(about_text)),$(if $(filter $(1),$(WORKING_FOLDERS)),$(about_folder)), \
                    $(if $(filter $(1),$(TEXT_VARIABLES)),,$(or $(about_words),$(if $(filter $(1),$(WORD_VARIABLES)),$(about_word)),$(if $(filter $(1),$(NAMES_VARIABLES)),$(about_names)))), \
                    $(if $(filter THREADS ARRAY PATIENCE EVERY RETRIES SCALE,$(1)),$(about_number)),$(if $(filter TIMEOUT BUDGET,$(1)),$(about_seconds)),$(if $(filter CROP,$(1)),$(about_numbers)),$(if $(filter DEVICE,$(1)),$(about_device)))
about_text = $(if $(filter PROMPT,$(1)),,$(if $(has_control_2),a line end or a control character is no part of it))
has_control_2 = $(call has_control,$(2))
about_folder = $(if $(call is_plain,$(2)),,GNU Make cannot work in a folder whose name begins with - or has spaces or one of $(strip $(special)): give another $(1))
about_words = $(if $(call are_words,$(2)),,make and a shell read it$(,) expected words without $(strip $(shell_special)))
about_word = $(if $(and $(filter 1,$(words $(2))),$(if $(filter -%,$(2)),,y)),,expected one word that does not begin with -)
about_names = $(if $(strip $(foreach w,$(2),$(if $(call is_plain,$(w)),,$(w)))),expected names)
about_number = $(if $(call without_digits,0 1 2 3 4 5 6 7 8 9,$(2)),expected a number)
about_seconds = $(if $(call without_digits,0 1 2 3 4 5 6 7 8 9 .,$(2)),expected a number of seconds)
about_numbers = $(if $(filter-out $(foreach d,0 1 2 3 4 5 6 7 8 9 .,-$(d)%),$(filter -%,$(2))),expected six numbers or auto)
about_device = $(if $(filter auto cpu cuda,$(2)),,expected auto$(,) cpu or cuda)
without_digits = $(if $(1),$(call without_digits,$(wordlist 2,11,$(1)),$(subst $(firstword $(1)),,$(2))),$(2))
, := ,

# A key in a URL would be written into the run's folder. The value is not repeated.
number_sign := \#
URL_VARIABLES := AGENT SCENE_AGENT PERCEPTION PREDICTOR
may_hold_credential = $(if $(findstring ?,$(value $(1))),$(shell bash $(LITERAL)url-credentials.sh $(call quoted,$(value $(1)))))
$(foreach v,$(URL_VARIABLES),$(if $(or $(findstring ://,$(value $(v))),$(if $(filter replay:%,$(firstword $(value $(v)))),,$(findstring @,$(value $(v))))), \
  $(if $(or $(call holds_any,@ $(number_sign),$(value $(v))),$(call may_hold_credential,$(v))),$(error \
  $(v) holds a user name, a password, or what may be one in its query: the key belongs into the environment variable PM_API_KEY$(,) or into HEADERS=file))))
$(foreach v,$(ASKED) $(FROM_ENVIRONMENT),$(if $(value $(v)),$(if $(strip $(call complaint,$(v))),$(error $(v)=$(call said,$(value $(v))): $(strip $(call complaint,$(v)))))))

# $(call given_to_tools,NAMES): as the user typed it, in the tools' environment as PM_ASKED_NAME.
given_to_tools = $(foreach v,$(1),$(eval export PM_ASKED_$(v) := $$(value $(v))))
# $(call option,FLAG=,VARIABLE): the flag and the variable's value, where it has one.
option = $(if $($(2)),$(1)"$$PM_ASKED_$(2)")
