# The DAG of one run (paper, Algorithm 1). Included by runs.mk for the goals `run`, `demo` and `preview`, and by batch.mk for every scene that it
# has something to do for.
#
# RUN      the run's folder
# Where the scene comes from, one of (inputs.mk):
#   EXAMPLE    name of a description in examples/           -> pm-scene synth
#   GAUSSIANS  a 3DGS file, with PROMPT and optionally UP, FRONT, INVENTORY, MASKS, VIEWS and CAMERAS (with DATAPARSER), PHYSGAUSSIAN,
#              MATERIALS, OPACITY, CROP, READ, DROP, AZIMUTH and ELEVATION of the output camera                    -> pm-scene import
#   SCENE      a scene.json                                 -> used where it lies
# PROMPT   what shall happen, instead of what the scene says
# PLAN     a plan whose actions are taken in place of those that the prompt gives (marked-plan.json)      -> pm-ground --plan
# MATERIAL what parts are made of: MATERIAL="head=Rubber body=Wood" or MATERIAL=Rubber                   -> pm-ground --material
# SPEC     a run specification: below what is imported, above an example's or a bundle's own
# SET      run settings that win over the scene's: SET="screening.tau=0.6 time.frames=20"
# CAMERA   of the videos: fixed (the scene's), fit (keeps what moves in the picture) or orbit (and turns)  -> SET=render.camera=...
# DEFAULTS run settings where the scene says nothing; by default those of a picture to look at
# SCENE_AGENT  who proposes inventory and plan: builtin, the URL of a chat server (with MODEL), or replay:DIR  -> pm-ground --agent
# PERCEPTION   who makes masks: builtin, the URL of an inference server, or replay:DIR                    -> pm-ground --perception
# AGENT    who looks at the rows: builtin, the URL of a chat server (with MODEL), or replay:DIR    -> pm-material --agent
# PREDICTOR  none, the URL of an inference server, replay:DIR, or a file of records          -> pm-material --predictor
# TIMEOUT, BUDGET, RETRIES  seconds for one reply of these servers and for all, and how often a request is sent again
# HEADERS  a file of further headers for these servers (Name: value), whose values are kept secret      -> --headers
# BODY     a JSON file of further fields of a request to a chat server                                  -> --body
# TENSORS  how inference servers get tensors: auto, json or binary                                      -> --tensors
# AUTHORED a file of authored material records                                               -> pm-material --authored
# BASE     another run of the same scene: ground, lift and material whose inputs are equal to its inputs take its results
# ERROR    1: also estimate the accepted run's discretisation error, from the same scene on fewer cells     -> pm-eval error
# THREADS  threads per tool; by default the executor says how many
# DEVICE   where simulations run: auto, cpu or cuda                                               -> pm-simulate --device
# EXECUTOR where tools run: the name of a file in executors/ (local), or a file
#
# Two conventions carry the incremental behaviour:
#
# 1. A stage's rule makes a stamp in RUN/.stamps; its artifacts hang on the stamp by an empty recipe. Tools leave an
#    unchanged artifact its timestamp, so a stage that reran without effect stops there. A missing artifact makes its
#    stage run again (see `missing`).
#
# 2. Which candidates a round has, and whether there is another round, is known only after a stage has run. The tools
#    write those facts as a line each (candidates/roundN.mk, screen/roundN.mk). GNU Make brings them up to date and reads
#    itself again, one fact at a time: the number of restarts says which of them can be trusted. It is one graph; no make
#    calls another. What lies in a run's folder is data: make reads the lines (`fact`) and includes none of it.

# Recipes name the run by $(RUN) and $(STAMPS), which in a batch is that of their own target.
STAMPS = $(RUN)/.stamps
PHASE := $(if $(MAKE_RESTARTS),$(MAKE_RESTARTS),0)

# The name of a stage's job is its stamp's.
threads = $(call job_threads,$(@F))

# $(call missing,FILES): FORCE when one of the files is not there.
missing = $(if $(filter-out $(wildcard $(1)),$(1)),FORCE)
# $(call stage,NAME,WHAT): announce a stage, and note that this run did something.
stage = @mkdir -p $(STAMPS) && touch $(STAMPS)/work && printf '  %-10s %s\n' '$(1)' '$(2)' $(to_log)
# $(call finish,WORDS): the end of a stage. WORDS are the shell's, and name what the stage may have made beside the files that its
# rule names: those that are there are listed beside its stamp, and `promised` asks for them in the next run.
finish = @shopt -s nullglob; for f in $(1); do [ ! -f "$$f" ] || printf '%s\n' "$${f\#$(RUN)/}"; done >$@.files; touch $@
promised = $(call missing,$(STAMPS)/$(1).files $(addprefix $(RUN)/,$(call held,$(file <$(STAMPS)/$(1).files))))

# Tools note beside the stamp how long a stage took, or why it failed (lib/base/stage_notes.h).
$(RUN)/.stamps/%: export PM_STAGE = $@
# $(explain): in front of a stage's job. Where it fails, the page of the run says so; make ends as it would without. Make passes an
# interruption on to what the recipe starts: one command, without anything behind it.
explain = bash $(PIPELINES)explained.sh $(RUN) $(@F) $(BIN) --

.PHONY: FORCE
FORCE:

# --- What was asked for: rewritten only when it changes -----------------------------------------------------------

SETTINGS := $(SET) $(CAMERA:%=render.camera=%) $(DEFAULTS:%=default %)
# Time limits and headers say how a server is reached, not what it is asked: another value does not ask again.
GROUND_MODELS := $(foreach v,SCENE_AGENT PERCEPTION $(if $(SCENE_AGENT),MODEL $(call given,BODY)) $(if $(PERCEPTION),$(call given,TENSORS)) $(call given,MATERIAL PLAN),$(v)=$(value $(v))$(newline))
MODELS := $(foreach v,AGENT MODEL PREDICTOR AUTHORED $(if $(AGENT),$(call given,BODY)) $(if $(PREDICTOR),$(call given,TENSORS)),$(v)=$(value $(v))$(newline))
include $(PIPELINES)inputs.mk
$(eval $(call remember,$(RUN)/settings,$(SETTINGS)))
$(eval $(call remember,$(RUN)/ground-models,$(GROUND_MODELS)))
$(eval $(call remember,$(RUN)/models,$(MODELS)))

# --- The run specification, one slice per stage -------------------------------------------------------------------

SLICES := $(foreach s,ground lift material candidates simulate render screen,$(RUN)/spec/$(s).json)
# Settings are words: each is one argument, whatever it holds.
$(STAMPS)/spec: $(BUNDLE_FILES) $(RUN)/settings $(RUN)/changes $(if $(GAUSSIANS),,$(in_make_SPEC)) \
                $(call missing,$(SLICES)) $(call promised,spec) | $(call built,pm-scene)
	$(call stage,spec,$(RUN)/spec)
	@set -f; settings=(); for s in $$PM_ASKED_SET $(if $(CAMERA),"render.camera=$$PM_ASKED_CAMERA"); do settings+=("--set=$$s"); done; \
	for s in $$PM_ASKED_DEFAULTS; do settings+=("--default=$$s"); done; \
	$(explain) $(call job,$(@F),1,$(job_inputs) $(BUNDLE),$(SLICES),$@.log) \
	$(BIN)/pm-scene slice --scene "$$PM_SCENE_FILE" --out $(RUN)/spec "$${settings[@]}" \
	  $(if $(GAUSSIANS),,$(call option,--prompt=,PROMPT) $(call option,--overrides=,SPEC))
	$(call finish,$(RUN)/spec/camera.mk)
$(SLICES): $(STAMPS)/spec ;

# $(call or_base,INPUTS,OUTPUTS): in front of a command that makes OUTPUTS from INPUTS, files of this run: not computed where
# BASE has made them from the same bytes.
or_base = $(if $(BASE),( $(foreach f,$(1),cmp -s $(RUN)/$(f) $(BASE)/$(f) &&) \
  for f in $(2); do [ -e $(BASE)/$$f ] || exit 1; done && \
  for f in $(2); do cmp -s $(BASE)/$$f $(RUN)/$$f || cp $(BASE)/$$f $(RUN)/$$f || exit; done ) ||)

# $(call server_options,AGENT): how the servers of a stage are asked, of which AGENT is its chat server.
server_options = $(call option,--timeout=,TIMEOUT) $(call option,--budget=,BUDGET) $(call option,--retries=,RETRIES) \
  $(call option,--headers=,HEADERS) $(call option,--tensors=,TENSORS) $(if $($(1)),$(call option,--body=,BODY))

# --- Scene agent, lifting, material agent -------------------------------------------------------------------------

GROUNDED := $(RUN)/inventory.json $(RUN)/plan.json $(RUN)/masks.h5
$(STAMPS)/ground: $(RUN)/spec/ground.json $(RUN)/ground-models $(REPLAYED_SCENE_AGENT) $(REPLAYED_PERCEPTION) \
                  $(if $(SCENE_AGENT),$(in_make_BODY)) $(in_make_PLAN) \
                  $(call missing,$(GROUNDED)) $(call promised,ground) | $(call built,pm-ground)
	$(call stage,ground,$(RUN)/inventory.json)
	@$(if $(or $(PLAN),$(and $(SCENE_AGENT),$(BODY))),,$(call or_base,spec/ground.json ground-models,inventory.json plan.json masks.h5)) \
	$(explain) $(call job,$(@F),$(threads),$(job_inputs),$(GROUNDED),$@.log) \
	$(BIN)/pm-ground --scene $< --out $(RUN) $(call option,--agent=,SCENE_AGENT) $(if $(SCENE_AGENT),$(call option,--model=,MODEL)) \
	  $(call option,--perception=,PERCEPTION) $(if $(call given,SCENE_AGENT PERCEPTION),$(call server_options,SCENE_AGENT)) \
	  $(call option,--plan=,PLAN) $(call option,--material=,MATERIAL) --threads $(threads)
	$(call finish,$(if $(call given,SCENE_AGENT PERCEPTION),$(RUN)/exchanges/{ground,detector,segmenter}_*.json $(RUN)/exchanges/*.{png,bin}))
$(GROUNDED): $(STAMPS)/ground ;

$(STAMPS)/lift: $(RUN)/spec/lift.json $(RUN)/inventory.json $(RUN)/masks.h5 $(call missing,$(RUN)/state.h5) | $(call built,pm-lift)
	$(call stage,lift,$(RUN)/state.h5)
	@$(call or_base,spec/lift.json inventory.json masks.h5,state.h5) \
	$(explain) $(call job,$(@F),$(threads),$(job_inputs),$(RUN)/state.h5,$@.log) \
	$(BIN)/pm-lift --scene $< --inventory $(RUN)/inventory.json --masks $(RUN)/masks.h5 --out $(RUN)/state.h5 --threads $(threads)
	$(finish)
$(RUN)/state.h5: $(STAMPS)/lift ;

MATERIAL_INPUTS := $(REPLAYED_AGENT) $(REPLAYED_PREDICTOR) $(in_make_AUTHORED) $(in_make_PREDICTOR) $(if $(AGENT),$(in_make_BODY))
$(STAMPS)/material: $(RUN)/spec/material.json $(RUN)/inventory.json $(RUN)/masks.h5 $(RUN)/state.h5 $(RUN)/models \
                    $(MATERIAL_INPUTS) $(call missing,$(RUN)/evidence.json) $(call promised,material) | $(call built,pm-material)
	$(call stage,material,$(RUN)/evidence.json)
	@$(if $(MATERIAL_INPUTS),,$(call or_base,spec/material.json inventory.json masks.h5 state.h5 models,evidence.json)) \
	$(explain) $(call job,$(@F),$(threads),$(job_inputs),$(RUN)/evidence.json,$@.log) \
	$(BIN)/pm-material --scene $< --inventory $(RUN)/inventory.json --masks $(RUN)/masks.h5 --state $(RUN)/state.h5 \
	  --out $(RUN)/evidence.json $(call option,--agent=,AGENT) $(if $(AGENT),$(call option,--model=,MODEL)) \
	  $(call option,--predictor=,PREDICTOR) $(if $(call given,AGENT PREDICTOR),$(call server_options,AGENT)) $(call option,--authored=,AUTHORED) --threads $(threads)
	$(call finish,$(if $(call given,AGENT PREDICTOR),$(RUN)/exchanges/{material,predictor}_*.json $(RUN)/exchanges/*.{png,bin}))
$(RUN)/evidence.json: $(STAMPS)/material ;

# --- Candidates of a round, and what is done with each ------------------------------------------------------------

# $(eval) reads these rules once more, so that a $$(call ...) in a recipe is given its arguments unexpanded, as $$(...).

# $(call candidates_rules,N,PREVIOUS): the candidates of round N; from round 1 on they are repairs that the screen of the
# PREVIOUS one asked for.
define candidates_rules
$(STAMPS)/candidates$(1): $(RUN)/spec/candidates.json $(RUN)/inventory.json $(RUN)/plan.json $(RUN)/evidence.json \
    $(RUN)/state.h5 $(if $(2),$(RUN)/screen/round$(2).json) \
    $(call missing,$(RUN)/candidates/round$(1).json $(RUN)/candidates/round$(1).mk $(PM_ROUND$(1):%=$(RUN)/candidates/%.json)) \
    | $(call built,pm-candidates)
	$$(call stage,candidates,$$(RUN)/candidates/round$(1).json)
	@$$(explain) $$(call job,$$(@F),$$(threads),$$(job_inputs),$$(RUN)/candidates/round$(1).json $$(RUN)/candidates/round$(1).mk,$$@.log) \
	$(BIN)/pm-candidates --scene $$< --inventory $(RUN)/inventory.json --plan $(RUN)/plan.json \
	  --evidence $(RUN)/evidence.json --state $(RUN)/state.h5 --out $(RUN)/candidates \
	  $(if $(2),--repair $(RUN)/screen/round$(2).json) --threads $$(threads)
	@bash $(PIPELINES)remove-stale.sh $(RUN) $(1) candidates
	$$(finish)
$(RUN)/candidates/round$(1).json $(RUN)/candidates/round$(1).mk $(PM_ROUND$(1):%=$(RUN)/candidates/%.json): \
    $(STAMPS)/candidates$(1) ;
endef

# $(call camera_rules,N,PREVIOUS,IDS): where the videos of round N are seen from, when it is fitted: from where the motion of its
# candidates IDS and of all PREVIOUS ones stays in the picture.
define camera_rules
$(STAMPS)/camera$(1): $(RUN)/spec/render.json $(RUN)/state.h5 $(3:%=$(RUN)/rollouts/%.h5) $(3:%=$(RUN)/rollouts/%.json) \
    $(2:%=$(RUN)/cameras/round%.json) $(call missing,$(RUN)/cameras/round$(1).json) | $(call built,pm-render)
	$$(call stage,camera,$$(RUN)/cameras/round$(1).json)
	@$$(explain) $$(call job,$$(@F),$$(threads),$$(job_inputs),$$(RUN)/cameras/round$(1).json,$$@.log) \
	$(BIN)/pm-render fit --scene $$< --state $(RUN)/state.h5 --rollout $(3:%=$(RUN)/rollouts/%.h5) \
	  $(2:%=--widen $(RUN)/cameras/round%.json) --out $(RUN)/cameras/round$(1).json --threads $$(threads)
	$$(finish)
$(RUN)/cameras/round$(1).json: $(STAMPS)/camera$(1) ;
endef

# $(call candidate_rules,ID,CAMERAS,PART): simulation and rendering of one candidate. CAMERAS: of its round, where they are fitted; PART:
# which of how many it is in its round, 2/6, for the tools' progress lines.
define candidate_rules
$(STAMPS)/simulate-$(1): $(RUN)/spec/simulate.json $(RUN)/state.h5 $(RUN)/candidates/$(1).json \
    $(call missing,$(RUN)/rollouts/$(1).h5 $(RUN)/rollouts/$(1).json) | $(call built,pm-simulate)
	$$(call stage,simulate,$$(RUN)/rollouts/$(1).h5)
	@PM_CANDIDATE=$(3) $$(explain) $$(call job,$$(@F),$$(threads),$$(job_inputs),$$(RUN)/rollouts/$(1).h5 $$(RUN)/rollouts/$(1).json,$$@.log) \
	$(BIN)/pm-simulate --scene $$< --state $(RUN)/state.h5 --candidate $(RUN)/candidates/$(1).json \
	  --out $(RUN)/rollouts/$(1).h5 --threads $$(threads)$(if $(DEVICE), --device $(DEVICE))
	$$(finish)
$(RUN)/rollouts/$(1).h5 $(RUN)/rollouts/$(1).json: $(STAMPS)/simulate-$(1) ;
$(STAMPS)/render-$(1): $(RUN)/spec/render.json $(RUN)/state.h5 $(RUN)/rollouts/$(1).h5 $(RUN)/rollouts/$(1).json $(2) \
    $(call missing,$(RUN)/videos/$(1).json) $(call promised,render-$(1)) | $(call built,pm-render)
	$$(call stage,render,$$(RUN)/videos/$(1).mp4)
	@PM_CANDIDATE=$(3) $$(explain) $$(call job,$$(@F),$$(threads),$$(job_inputs),$$(RUN)/videos/$(1).json,$$@.log) \
	$(BIN)/pm-render --scene $$< --state $(RUN)/state.h5 --rollout $(RUN)/rollouts/$(1).h5 \
	  --out $(RUN)/videos/$(1).mp4 --sheet $(RUN)/videos/$(1).png --candidate $(RUN)/candidates/$(1).json $(2:%=--cameras %) --threads $$(threads)
	$$(call finish,$$(RUN)/videos/$(1).mp4 $$(RUN)/videos/$(1).png)
$(RUN)/videos/$(1).json: $(STAMPS)/render-$(1) ;
endef

# $(call screen_rules,N,IDS,ROUNDS): screen everything that was executed in ROUNDS, 0..N. Exit code 6, "no admissible
# candidate", is a verdict that the record holds; the goal `run` reports it.
define screen_rules
$(STAMPS)/screen$(1): $(RUN)/spec/screen.json $(RUN)/plan.json $(RUN)/evidence.json $(RUN)/inventory.json \
    $(3:%=$(RUN)/candidates/round%.json) $(2:%=$(RUN)/candidates/%.json) $(2:%=$(RUN)/rollouts/%.json) $(2:%=$(RUN)/videos/%.json) \
    $(call missing,$(RUN)/screen/round$(1).json $(RUN)/screen/round$(1).mk $(if $(filter accept,$(PM_DECISION$(1))),$(RUN)/accepted.json $(RUN)/final.mp4)) | $(call built,pm-screen)
	$$(call stage,screen,$$(RUN)/screen/round$(1).json)
	@PM_FINE=6 $$(explain) $$(call job,$$(@F),$$(threads),$$(job_inputs),$$(RUN)/screen/round$(1).json $$(RUN)/screen/round$(1).mk,$$@.log) \
	$(BIN)/pm-screen --scene $$< --plan $(RUN)/plan.json --evidence $(RUN)/evidence.json \
	  --inventory $(RUN)/inventory.json --candidates $(RUN)/candidates --rollouts $(RUN)/rollouts \
	  --videos $(RUN)/videos --round $(1) --out $(RUN)/screen/round$(1).json \
	  --accepted $(RUN)/accepted.json --final $(RUN)/final.mp4 --quiet --threads $$(threads) || [ $$$$? -eq 6 ]
	@bash $(PIPELINES)remove-stale.sh $(RUN) $(1) screen
	$$(finish)
$(RUN)/screen/round$(1).json $(RUN)/screen/round$(1).mk: $(STAMPS)/screen$(1) ;
endef

# --- Rounds -------------------------------------------------------------------------------------------------------

# The facts in the order in which they are learned, one with each restart, and those that are up to date in this
# invocation. A run specification has at most three rounds.
FACTS := $(foreach n,0 1 2,candidates/round$(n).mk screen/round$(n).mk)
KNOWN := $(wordlist 1,$(PHASE),$(FACTS))
known = $(addprefix $(RUN)/,$(filter $(1),$(KNOWN)))
# Whether the camera is fitted is known with the first of them.
# $(eval $(call fact,VARIABLE,FILE)): the words behind "VARIABLE :=", the one line that a tool wrote into FILE.
define fact
fact_words := $$(if $(2),$$(file <$(2)))
ifneq ($$(strip $$(foreach w,$$(wordlist 3,999,$$(fact_words)),$$(if $$(call is_plain,$$(w)),,bad))$$(if $(2),$$(filter-out $(1) :=,$$(wordlist 1,2,$$(fact_words))))),)
  $$(call refuse,$(2): found "$$(call said,$$(fact_words))"$$(,) expected $(1) := names; remove it$$(,) and it is made again)
  fact_words :=
endif
$(1) := $$(wordlist 3,999,$$(fact_words))
endef
$(eval $(call fact,PM_CAMERA,$(if $(KNOWN),$(wildcard $(RUN)/spec/camera.mk))))
PM_CAMERA := $(filter fit orbit,$(PM_CAMERA))

# $(call round_rules,N): round N, after those in ROUNDS, as far as it is known.
define round_rules
PREVIOUS := $(LAST_ROUND)
LAST_ROUND := $(1)
ROUNDS += $(1)
$$(eval $$(call fact,PM_ROUND$(1),$$(call known,candidates/round$(1).mk)))
IDS += $$(PM_ROUND$(1))
$$(eval $$(call candidates_rules,$(1),$$(PREVIOUS)))
COUNTED :=
$$(foreach id,$$(PM_ROUND$(1)),$$(eval COUNTED += $$(id))$$(eval $$(call candidate_rules,$$(id),$$(PM_CAMERA:%=$$(RUN)/cameras/round$(1).json),$$(words $$(COUNTED))/$$(words $$(PM_ROUND$(1))))))
$$(if $$(and $$(PM_CAMERA),$$(PM_ROUND$(1))),$$(eval $$(call camera_rules,$(1),$$(PREVIOUS),$$(PM_ROUND$(1))))$$(eval BEST_CAMERAS := $$(RUN)/cameras/round$(1).json))
$$(eval $$(call fact,PM_DECISION$(1),$$(call known,screen/round$(1).mk)))
$$(eval $$(call screen_rules,$(1),$$(IDS),$$(ROUNDS)))
endef
ROUNDS :=
IDS :=
LAST_ROUND :=
# What the best candidate is seen with, where nothing is accepted.
BEST_CAMERAS :=
$(eval $(call round_rules,0))
# The next one, when the screen of the last is known and asked for repairs.
$(foreach n,1 2,$(if $(filter repair,$(PM_DECISION$(LAST_ROUND))),$(eval $(call round_rules,$(n)))))

# The first fact of these rounds that is not known yet.
NEXT := $(firstword $(filter-out $(KNOWN),$(foreach n,$(ROUNDS),$(filter %/round$(n).mk,$(FACTS)))))

# `make -n` must not run anything, so it sees the graph only as far as it is known.
# A preview ends with the candidates of the first round.
ifneq ($(DRY)$(filter preview,$(MAKECMDGOALS)),)
  NEXT :=
endif
# A batch waits for the end of the run, too, where no fact is left to be learned.
STEP := $(or $(NEXT:%=$(RUN)/%),$(if $(DRY),,$(LAST_STEP)))
ifneq ($(STEP),)
  # All tools are built before the first restart: later readings skip the header dependencies.
  PHASE_FILE := $(STAMPS)/phase$(words $(KNOWN) $(STEP)).mk
  # Always remade, so that make reads itself again once what it hangs on is up to date.
  $(PHASE_FILE): $(STEP) FORCE | $(call built,$(RUN_TOOLS))
	$(if $(NEXT),@echo '# learned' >$@)
  # Empty, whatever lay there. Where a stage fails, make shall not also say that this file is not there.
  $(file >$(PHASE_FILE),)
  ifeq ($(LAST_STEP),)
    include $(PHASE_FILE)
  else
    -include $(PHASE_FILE)
  endif
endif

# --- The end of a run ---------------------------------------------------------------------------------------------

ACCEPTED := $(filter accept,$(PM_DECISION$(LAST_ROUND)))

# A run in which nothing is accepted shows its best candidate, with the reasons in the picture.
$(STAMPS)/best: $(RUN)/spec/render.json $(RUN)/state.h5 $(RUN)/screen/round$(LAST_ROUND).json $(IDS:%=$(RUN)/rollouts/%.h5) \
                $(IDS:%=$(RUN)/rollouts/%.json) $(BEST_CAMERAS) \
                $(call missing,$(RUN)/best.mp4) | $(call built,pm-render)
	$(call stage,best,$(RUN)/best.mp4)
	@$(explain) $(call job,$(@F),$(threads),$(job_inputs),$(RUN)/best.mp4,$@.log) \
	$(BIN)/pm-render best --scene $< --state $(RUN)/state.h5 --screen $(RUN)/screen/round$(LAST_ROUND).json \
	  --rollouts $(RUN)/rollouts --candidates $(RUN)/candidates $(BEST_CAMERAS:%=--cameras %) --out $(RUN)/best.mp4 --quiet --threads $(threads)
	$(finish)

# The discretisation error of what was accepted, for who asks.
$(STAMPS)/error: $(RUN)/spec/simulate.json $(RUN)/spec/render.json $(RUN)/state.h5 $(RUN)/screen/round$(LAST_ROUND).json \
                 $(call missing,$(RUN)/error.json) | $(call built,pm-eval)
	$(call stage,error,$(RUN)/error.json)
	@$(explain) $(call job,$(@F),$(threads),$(job_inputs),$(RUN)/error.json,$@.log) \
	$(BIN)/pm-eval error --scene $< --view $(RUN)/spec/render.json --state $(RUN)/state.h5 --accepted $(RUN)/accepted.json \
	  --out $(RUN)/error.json --threads $(threads) $(to_log)
	$(finish)

# --- Before a run -------------------------------------------------------------------------------------------------

ifneq ($(filter preview,$(MAKECMDGOALS)),)
PREVIEW := $(RUN)/preview.html $(RUN)/preview.png $(RUN)/preview.json
$(STAMPS)/preview: $(foreach s,ground simulate render,$(RUN)/spec/$(s).json) $(GROUNDED) $(RUN)/state.h5 $(RUN)/evidence.json \
                   $(RUN)/candidates/round0.json $(call missing,$(PREVIEW)) | $(call built,pm-report)
	$(call stage,preview,$(RUN)/preview.html)
	@$(call job,$(@F),$(threads),$(job_inputs),$(PREVIEW),$@.log) $(BIN)/pm-report preview --run $(RUN) --out $(RUN)/preview.html --threads $(threads)
	$(finish)

.PHONY: run-previewed
run-previewed: $(STAMPS)/preview
	@rm -f $(STAMPS)/work; printf '  page     %s\n  picture  %s\n' $(RUN)/preview.html $(RUN)/preview.png
	@$(if $(OPEN),xdg-open $(RUN)/preview.html >/dev/null 2>&1 || { echo "xdg-open cannot open $(RUN)/preview.html" >&2; exit 1; })
endif

# The page of the run. What was asked for is shown in it.
$(STAMPS)/report: $(RUN)/screen/round$(LAST_ROUND).json $(if $(filter fail,$(PM_DECISION$(LAST_ROUND))),$(STAMPS)/best) \
                  $(if $(ERROR),$(if $(ACCEPTED),$(STAMPS)/error)) \
                  $(foreach f,settings changes models ground-models,$(RUN)/$(f)) $(call missing,$(RUN)/report.html $(RUN)/report.json) | $(call built,pm-report)
	$(call stage,report,$(RUN)/report.html)
	@$(call job,$(@F),$(threads),$(job_inputs),$(RUN)/report.html $(RUN)/report.json,$@.log) $(BIN)/pm-report --run $(RUN) --out $(RUN)/report.html --threads $(threads)
	$(finish)

.PHONY: $(FINISHED)
$(FINISHED): $(RUN)/screen/round$(LAST_ROUND).json $(STAMPS)/report
ifneq ($(ACCEPTED),)
	@{ if [ -e $(STAMPS)/work ]; then echo "Accepted."; else echo "Nothing to do: $(RUN) is up to date."; fi; \
	printf '  video   %s\n  report  %s\n  audit   %s\n  screen  %s\n' $(RUN)/final.mp4 $(RUN)/report.html $(RUN)/accepted.json $(RUN)/screen/round$(LAST_ROUND).json; \
	$(if $(ERROR),printf '  error   %s\n' $(RUN)/error.json;) } $(to_log)
	@rm -f $(STAMPS)/work $(STAMPS)/best $(RUN)/best.mp4
	$(call ended,0)
else
	@rm -f $(STAMPS)/work
	@$(call job,explain,1,$(job_inputs),,$(STAMPS)/explain.log) \
	$(BIN)/pm-screen --explain --out $(RUN)/screen/round$(LAST_ROUND).json
	@echo "No candidate was admitted: see $(RUN)/screen/round$(LAST_ROUND).json; the best is $(RUN)/best.mp4, and $(RUN)/report.html shows all" $(or $(to_log),>&2)
	$(call ended,6)
endif
