# Many scenes, one call: make -j2 batch SCENES="cake ball-glass", or SCENES=list.txt. Included by runs.mk for the goal
# `batch`.
#
# SCENES   names of examples, scene.json files and files of Gaussians; or one text file of them, one per line, where variables of
#          `make run` may follow: guitar.ply UP=-y "PROMPT=the guitar falls"     (# starts a comment)
# BATCH    the folder, by default runs/batch: a run per scene in BATCH/NAME with its log.txt, and table.tsv
# Variables that are given to make itself (SET, THREADS, ...) count for every scene.
#
# Which candidates and rounds a scene has is known only while it runs, and GNU Make learns such facts by reading itself
# again (physmas.mk). So that one scene's facts and failures stay its own, each scene is a make of its own under this one;
# all of them share its job slots.

BATCH ?= runs/batch
BATCH_LIST := $(BATCH)/scenes.list
BATCH_NAMES := $(shell EXAMPLES=$(EXAMPLES) bash $(PIPELINES)batch-scenes.sh $(if $(DRY),/dev/null,$(BATCH_LIST)) $(call quoted,$(SCENES)) \
  $(call quoted,$(RUN_VARIABLES)) 2>&1)
ifneq ($(.SHELLSTATUS),0)
  $(error $(BATCH_NAMES))
endif

.PHONY: batch-finished $(BATCH_NAMES:%=batch-scene-%)

ifeq ($(DRY),)
# The recipe does not fail: what went wrong is the scene's row of the table.
$(BATCH_NAMES:%=batch-scene-%): batch-scene-%: | $(call built,$(RUN_TOOLS))
	+@mkdir -p $(BATCH)/$*; start=$$(date +%s%N); \
	mapfile -t arguments < <(while IFS= read -r line; do [ "$${line%%$$'\t'*}" != $* ] || printf '%s\n' "$${line#*$$'\t'}"; done <$(BATCH_LIST) | tr '\t' '\n'); \
	status=0; $(MAKE) $(SAME_MAKE) --no-print-directory run "$${arguments[@]}" RUN=$(BATCH)/$* SCENES= BATCH= \
	  >$(BATCH)/$*/log.txt 2>&1 </dev/null || status=$$?; \
	echo "$$status $$(( ($$(date +%s%N) - start) / 1000000 ))" | awk '{ printf "%d %.3f\n", $$1, $$2 / 1000 }' >$(BATCH)/$*/batch.status; \
	printf '  %-9s  %s\n' "$$([ $$status -eq 0 ] && echo accepted || echo failed)" $(BATCH)/$*
else
$(BATCH_NAMES:%=batch-scene-%): batch-scene-%:
	@echo "make run of $* in $(BATCH)/$*"
endif

batch-finished: $(BATCH_NAMES:%=batch-scene-%) | $(call built,pm-screen)
	@$(call job,table,1,$(BATCH_NAMES:%=$(BATCH)/%),$(BATCH)/table.tsv,$(BATCH)/table.log) \
	$(BIN)/pm-screen --table $(BATCH_NAMES:%=$(BATCH)/%) --out $(BATCH)/table.tsv
	@column -t -s "$$(printf '\t')" $(BATCH)/table.tsv 2>/dev/null || cat $(BATCH)/table.tsv
