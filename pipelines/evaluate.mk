# The registered benchmark: make -j2 evaluate [CASES="cake lamp"]. Included by the Makefile for the goal `evaluate`.
#
# SUITE     the registered suite, by default examples/suite.json with its hashes in examples/suite.sha256
# CASES     ids of some of its cases; by default all
# EVALUATE  the folder, by default runs/evaluate:
#   bundle/CASE/                 the scene, without the truth
#   CASE/METHOD/                 a run (physmas.mk)
#   truth/CASE/                  the true rows, for references only
#   references/CASE-KEY/         a reference: labels, configuration, rollout and video; KEY hashes all that shapes it
#   results/CASE/METHOD/         motion-OBJECT.json, and result.tsv: what came out, failures included
#   evaluation.json, tables/     what pm-eval makes of them
#
# A method's run is a make of its own and gets the bundle and run settings, nothing else (as in batch.mk, it shares the job
# slots). A result or reference that fails does not fail make: evaluate-run.sh writes the reason into its result.tsv.

SUITE ?= examples/suite.json
EVALUATE ?= runs/evaluate
CASES ?=
in_cases = $(if $(strip $(CASES)),--cases $(CASES))

# Hashes are checked in every call before anything else.
ifneq ($(shell MAKEFLAGS= MFLAGS= $(MAKE) --no-print-directory -s $(BIN)/pm-eval BUILD=$(BUILD) SAN=$(SAN) >&2 && mkdir -p $(EVALUATE) && \
  $(BIN)/pm-eval suite --suite $(SUITE) $(in_cases) --makefile $(EVALUATE)/suite.mk && echo checked),checked)
  $(error $(SUITE) was refused)
endif
include $(EVALUATE)/suite.mk
$(EVALUATE)/suite.mk: ;

BASE_METHOD := $(firstword $(SUITE_METHODS))
reference_of = $(EVALUATE)/references/$(1)-$(SUITE_KEY_$(1))
result_of = $(EVALUATE)/results/$(1)/$(2)/result.tsv
RESULTS := $(foreach c,$(SUITE_CASES),$(foreach m,$(SUITE_METHODS),$(call result_of,$(c),$(m))))

# $(call remember,FILE,TEXT): FILE holds TEXT, rewritten only when that changes.
remember = $(if $(subst x$(strip $(2)),,x$(strip $(file <$(1))))$(if $(wildcard $(1)),,new),$(file >$(1),$(strip $(2))))
ifneq ($(shell mkdir -p $(dir $(RESULTS)) && echo made),made)
  $(error $(EVALUATE) cannot be made: is its folder writable?)
endif

# $(call case_rules,CASE)
define case_rules
$(EVALUATE)/bundle/$(1)/scene.json: $(SUITE_EXAMPLE_$(1)) | $(BIN)/pm-scene
	@printf '  %-10s %s\n' synth $$(@D)
	@$(BIN)/pm-scene synth $$< --out $(EVALUATE)/synth/$(1) --quiet --threads 1
	@mkdir -p $(EVALUATE)/truth/$(1) && mv $(EVALUATE)/synth/$(1)/truth.h5 $(EVALUATE)/truth/$(1)/
	@rm -rf $$(@D) && mkdir -p $(EVALUATE)/bundle && mv $(EVALUATE)/synth/$(1) $$(@D) && touch $$@

$(call reference_of,$(1))/result.tsv: $(EVALUATE)/bundle/$(1)/scene.json $(SUITE_REFERENCE_$(1)) | $(TOOLS:%=$(BIN)/%)
	@printf '  %-10s %s\n' reference $$(@D)
	@BIN=$(BIN) pipelines/evaluate-reference.sh $(EVALUATE)/bundle/$(1)/scene.json $(EVALUATE)/truth/$(1)/truth.h5 \
	  $(SUITE_REFERENCE_$(1)) $$(@D) $(SUITE_SETTINGS) $(SUITE_REFERENCE_SETTINGS_$(1))
endef
$(foreach c,$(SUITE_CASES),$(eval $(call case_rules,$(c))))

# $(call result_rules,CASE,METHOD). The settings are remembered per result, so that another set of them runs it again.
define result_rules
$(call remember,$(EVALUATE)/results/$(1)/$(2)/request,$(SUITE_SETTINGS) $(SUITE_SETTINGS_$(2)) \
  candidate=$(SUITE_CANDIDATE_$(2)) objects=$(SUITE_OBJECTS_$(1)) reference=$(SUITE_KEY_$(1)))
$(EVALUATE)/results/$(1)/$(2)/request: ;
$(call result_of,$(1),$(2)): $(EVALUATE)/bundle/$(1)/scene.json $(EVALUATE)/results/$(1)/$(2)/request \
    $(call reference_of,$(1))/result.tsv $(if $(filter-out $(BASE_METHOD),$(2)),$(call result_of,$(1),$(BASE_METHOD)))
	+@mkdir -p $(EVALUATE)/$(1)/$(2); status=0; \
	$$(MAKE) --no-print-directory run SCENE=$(EVALUATE)/bundle/$(1)/scene.json RUN=$(EVALUATE)/$(1)/$(2) \
	  SET="$(SUITE_SETTINGS) $(SUITE_SETTINGS_$(2))" $(if $(filter-out $(BASE_METHOD),$(2)),BASE=$(EVALUATE)/$(1)/$(BASE_METHOD)) \
	  THREADS=1 EXAMPLE= GAUSSIANS= CASES= SUITE= >$(EVALUATE)/$(1)/$(2)/log.txt 2>&1 </dev/null || status=$$$$?; \
	BIN=$(BIN) pipelines/evaluate-result.sh $$$$status $(EVALUATE)/bundle/$(1)/scene.json $(EVALUATE)/$(1)/$(2) \
	  $(call reference_of,$(1)) $$(@D) "$(SUITE_CANDIDATE_$(2))" $(SUITE_OBJECTS_$(1))
	@printf '  %-10s %s\n' "$$$$(cut -f1 $$@)" $(EVALUATE)/$(1)/$(2)
endef
$(foreach c,$(SUITE_CASES),$(foreach m,$(SUITE_METHODS),$(eval $(call result_rules,$(c),$(m)))))

# Failures are in the tables; --draft keeps them from keeping the tables away.
.PHONY: evaluate-finished
evaluate-finished: $(RESULTS) | $(BIN)/pm-eval
	@$(BIN)/pm-eval collect --suite $(SUITE) $(in_cases) --results $(EVALUATE) --out $(EVALUATE)/evaluation.json
	@$(BIN)/pm-eval aggregate --manifest $(EVALUATE)/evaluation.json --draft --quiet --out $(EVALUATE)/tables
	@echo "Tables and the row of every result: $(EVALUATE)/tables"
