# The registered benchmark: make -j2 evaluate [CASES="cake lamp"]. Included by runs.mk for the goal `evaluate`.
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
# slots). A result or reference that fails does not fail make: evaluate-reference.sh and evaluate-result.sh write the reason
# into its result.tsv.

SUITE ?= $(EXAMPLES)suite.json
EVALUATE ?= runs/evaluate
CASES ?=
in_cases = $(if $(strip $(CASES)),--cases $(CASES))

# Hashes are checked in every call before anything else.
build_eval = $(if $(call built,pm-eval),MAKEFLAGS= MFLAGS= $(MAKE) --no-print-directory -s $(BIN)/pm-eval BUILD=$(BUILD) SAN=$(SAN) >&2,true)
ifneq ($(shell $(build_eval) && mkdir -p $(EVALUATE) && \
  $(BIN)/pm-eval suite --suite $(SUITE) $(in_cases) --makefile $(EVALUATE)/suite.mk && echo checked),checked)
  $(error $(SUITE) was refused)
endif
include $(EVALUATE)/suite.mk
$(EVALUATE)/suite.mk: ;

BASE_METHOD := $(firstword $(SUITE_METHODS))
reference_of = $(EVALUATE)/references/$(1)-$(SUITE_KEY_$(1))
result_of = $(EVALUATE)/results/$(1)/$(2)/result.tsv
RESULTS := $(foreach c,$(SUITE_CASES),$(foreach m,$(SUITE_METHODS),$(call result_of,$(c),$(m))))

ifneq ($(shell mkdir -p $(dir $(RESULTS)) && echo made),made)
  $(error $(EVALUATE) cannot be made: is its folder writable?)
endif

# $(call case_rules,CASE)
define case_rules
$(EVALUATE)/bundle/$(1)/scene.json: $(SUITE_EXAMPLE_$(1)) | $(call built,pm-scene)
	@printf '  %-10s %s\n' synth $$(@D)
	@$$(call job,synth-$(1),1,$$(job_inputs),$$(EVALUATE)/synth/$(1)/scene.json,$$(EVALUATE)/synth-$(1).log) \
	$(BIN)/pm-scene synth $$< --out $(EVALUATE)/synth/$(1) --quiet --threads 1
	@mkdir -p $(EVALUATE)/truth/$(1) && mv $(EVALUATE)/synth/$(1)/truth.h5 $(EVALUATE)/truth/$(1)/
	@rm -rf $$(@D) && mkdir -p $(EVALUATE)/bundle && mv $(EVALUATE)/synth/$(1) $$(@D) && touch $$@

$(call reference_of,$(1))/result.tsv: $(EVALUATE)/bundle/$(1)/scene.json $(SUITE_REFERENCE_$(1)) | $(call built,$(RUN_TOOLS))
	@printf '  %-10s %s\n' reference $$(@D)
	@$$(call job,reference-$(1),1,$$(job_inputs) $$(EVALUATE)/truth/$(1)/truth.h5,$$@,$$(EVALUATE)/reference-$(1).log) \
	env BIN=$(BIN) bash $(PIPELINES)evaluate-reference.sh $(EVALUATE)/bundle/$(1)/scene.json $(EVALUATE)/truth/$(1)/truth.h5 \
	  $(SUITE_REFERENCE_$(1)) $$(@D) $(SUITE_SETTINGS) $(SUITE_REFERENCE_SETTINGS_$(1))
endef
$(foreach c,$(SUITE_CASES),$(eval $(call case_rules,$(c))))

# What a result was made from: another set of settings runs it again.
result_request = $(strip $(SUITE_SETTINGS) $(SUITE_SETTINGS_$(2)) candidate=$(SUITE_CANDIDATE_$(2)) objects=$(SUITE_OBJECTS_$(1)) \
  reference=$(SUITE_KEY_$(1)))
# $(call result_rules,CASE,METHOD)
define result_rules
$(call remember,$(EVALUATE)/results/$(1)/$(2)/request,$(call result_request,$(1),$(2)))
$(call result_of,$(1),$(2)): $(EVALUATE)/bundle/$(1)/scene.json $(EVALUATE)/results/$(1)/$(2)/request \
    $(call reference_of,$(1))/result.tsv $(if $(filter-out $(BASE_METHOD),$(2)),$(call result_of,$(1),$(BASE_METHOD)))
	+@mkdir -p $(EVALUATE)/$(1)/$(2); status=0; \
	$$(MAKE) $(SAME_MAKE) --no-print-directory run SCENE=$(EVALUATE)/bundle/$(1)/scene.json RUN=$(EVALUATE)/$(1)/$(2) \
	  SET="$(SUITE_SETTINGS) $(SUITE_SETTINGS_$(2))" DEFAULTS= CAMERA= $(if $(filter-out $(BASE_METHOD),$(2)),BASE=$(EVALUATE)/$(1)/$(BASE_METHOD)) \
	  THREADS=1 EXAMPLE= GAUSSIANS= CASES= SUITE= EVALUATE= >$(EVALUATE)/$(1)/$(2)/log.txt 2>&1 </dev/null || status=$$$$?; \
	$$(call job,result-$(1)-$(2),1,$$(job_inputs) $$(EVALUATE)/$(1)/$(2),$$@,$$(EVALUATE)/result-$(1)-$(2).log) \
	env BIN=$(BIN) bash $(PIPELINES)evaluate-result.sh $$$$status $(EVALUATE)/bundle/$(1)/scene.json $(EVALUATE)/$(1)/$(2) \
	  $(call reference_of,$(1)) $$(@D) "$(SUITE_CANDIDATE_$(2))" $(SUITE_OBJECTS_$(1))
	@printf '  %-10s %s\n' "$$$$(cut -f1 $$@)" $(EVALUATE)/$(1)/$(2)
endef
$(foreach c,$(SUITE_CASES),$(foreach m,$(SUITE_METHODS),$(eval $(call result_rules,$(c),$(m)))))

# Failures are in the tables; --draft keeps them from keeping the tables away.
.PHONY: evaluate-finished
evaluate-finished: $(RESULTS) | $(call built,pm-eval)
	@$(call job,collect,1,$(job_inputs),$(EVALUATE)/evaluation.json,$(EVALUATE)/collect.log) \
	$(BIN)/pm-eval collect --suite $(SUITE) $(in_cases) --results $(EVALUATE) --out $(EVALUATE)/evaluation.json
	@$(call job,aggregate,1,$(EVALUATE)/evaluation.json,$(EVALUATE)/tables,$(EVALUATE)/aggregate.log) \
	$(BIN)/pm-eval aggregate --manifest $(EVALUATE)/evaluation.json --draft --quiet --out $(EVALUATE)/tables
	@echo "Tables and the row of every result: $(EVALUATE)/tables"
