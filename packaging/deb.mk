# `make deb`: a Debian package of a build for any processor (ARCH=baseline, in a folder of its own). Included by the Makefile.

MAINTAINER ?= The PhysMAS authors <authors@physmas.invalid>
$(call given_to_tools,MAINTAINER)
BASELINE := build/baseline
DEB = build/physmas_$(VERSION)_$(shell dpkg --print-architecture).deb

.PHONY: baseline deb deb-check check-processors
baseline: ## Build the tools for any processor of this kind into build/baseline, with kernels for SSE2, AVX2 and AVX-512
	@$(MAKE) --no-print-directory ARCH=baseline SAN=0 BUILD=$(BASELINE) all

# The tree's last change dates pages and package, so that the same tree gives the same package.
deb: baseline ## Make build/physmas_VERSION_ARCH.deb, which runs on any processor of this kind
	@rm -rf $(BASELINE)/deb
	@export SOURCE_DATE_EPOCH=$${SOURCE_DATE_EPOCH:-$$(git log -1 --format=%ct 2>/dev/null || stat -c %Y Makefile)}; \
	$(MAKE) --no-print-directory ARCH=baseline SAN=0 BUILD=$(BASELINE) install DESTDIR=$(BASELINE)/deb PREFIX=/usr && \
	packaging/make-deb.sh $(BASELINE)/deb $(VERSION) "$$PM_ASKED_MAINTAINER" $(DEB)

deb-check: deb ## Install the package into an empty Debian and run it there (as root, needs mmdebstrap and the network)
	@packaging/check-deb.sh $(DEB) tests/data/tiny.json $(BASELINE)/root

check-processors: baseline ## Test the baseline build with each set of kernels, and run it on emulated older processors (qemu-user-static)
	@$(MAKE) --no-print-directory ARCH=baseline SAN=0 BUILD=$(BASELINE) $(BASELINE)/test/unit
	@packaging/check-processors.sh $(BASELINE) tests/data/tiny.json
