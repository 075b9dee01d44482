# `make install` and `make uninstall`: PREFIX (/usr/local) below DESTDIR. Included by the Makefile.
#
# bin/pm-*                                        the tools
# share/man/man1/, share/bash-completion/         made from each tool's --help
# share/physmas/physmas.mk                        runs outside the tree: make -f PREFIX/share/physmas/physmas.mk run GAUSSIANS=... PROMPT=...
# share/physmas/{pipelines,schemas,examples}/
# share/physmas/manifest                          what was installed, one path below PREFIX per line: uninstall takes away just that
# share/doc/physmas/

PREFIX ?= /usr/local
$(call given_to_tools,DESTDIR PREFIX)
SHARE := $(BUILD)/share
MAN_PAGES := $(TOOLS:%=$(SHARE)/man/man1/%.1)
COMPLETIONS := $(TOOLS:%=$(SHARE)/bash-completion/completions/%)

# -B: no byte code beside the scripts.
PACKAGING := python3 -B packaging
$(MAN_PAGES): $(SHARE)/man/man1/%.1: $(BIN)/% packaging/man/%.md packaging/man_page.py packaging/tool_help.py docs/artifacts.md
	@mkdir -p $(@D)
	$(call say,MAN,$@)
	$(Q)$(PACKAGING)/man_page.py $< packaging/man/$*.md docs/artifacts.md $(VERSION) \
	  "$$(date -u -d "@$${SOURCE_DATE_EPOCH:-$$(stat -c %Y $<)}" +%F)" >$@

$(COMPLETIONS): $(SHARE)/bash-completion/completions/%: $(BIN)/% packaging/completion.py packaging/tool_help.py
	@mkdir -p $(@D)
	$(call say,BASH,$@)
	$(Q)$(PACKAGING)/completion.py $< >$@

.PHONY: man completions
man: $(MAN_PAGES) ## Make the man pages from the tools' --help, into build/share/man
completions: $(COMPLETIONS) ## Make the bash completion from the tools' --help, into build/share/bash-completion

# What is installed: FILE=PLACE, the place below PREFIX. An executable file stays one.
shared = $(foreach f,$(1),$(f)=share/physmas/$(f))
INSTALLED := $(foreach t,$(TOOLS),$(BIN)/$(t)=bin/$(t)) \
  $(foreach f,$(MAN_PAGES) $(COMPLETIONS),$(f)=$(f:$(BUILD)/%=%)) \
  $(call shared,$(filter-out pipelines/installed.mk,$(wildcard pipelines/*.mk pipelines/*.sh pipelines/*/*.mk pipelines/*/*.sh pipelines/*/*.txt))) \
  $(call shared,$(wildcard schemas/*.json schemas/*.md examples/*.json examples/*.sha256 examples/*/*.json examples/*/*.py examples/servers/triton-models/*/config.pbtxt examples/servers/triton-models/*/1/model.py)) \
  $(patsubst %,%=share/physmas/physmas.mk,$(wildcard pipelines/installed.mk)) \
  $(foreach f,LICENSE $(wildcard *.md *.cff docs/*.md docs/*.cff docs/images/*),$(f)=share/doc/physmas/$(f:docs/%=%))

.PHONY: install uninstall
install: all man completions ## Install tools, man pages, completion, pipelines, schemas, examples and docs into PREFIX=/usr/local
	@root=$$PM_ASKED_DESTDIR$$PM_ASKED_PREFIX; \
	if [ -e "$$root/share/physmas/manifest" ]; then packaging/uninstall.sh "$$root" || exit; fi; \
	{ for pair in $(INSTALLED); do \
	    from=$${pair%%=*} to=$${pair#*=}; \
	    if [ -x "$$from" ]; then mode=755; else mode=644; fi; \
	    install -D -m $$mode -- "$$from" "$$root/$$to" && echo "$$to" || exit; \
	  done && echo share/physmas/manifest; } >$(BUILD)/manifest && \
	install -m 644 -- $(BUILD)/manifest "$$root/share/physmas/manifest" && echo "Installed below $$root"

uninstall: ## Take away what make install put into PREFIX
	@packaging/uninstall.sh "$$PM_ASKED_DESTDIR$$PM_ASKED_PREFIX"
