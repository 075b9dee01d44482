# The moving pictures of README.md and docs/, from runs: make pictures GUITAR=guitar.compressed.ply. Needs ffmpeg and
# chromium (Debian's packages of these names). The guitar's file is no part of this project (docs/start.md says where it is from); without it its
# picture stays as it is. The runs are ordinary ones, in PICTURES/, and are not computed again.

PICTURES ?= runs/pictures
GUITAR ?=
MOVING := demo materials $(if $(GUITAR),guitar)

demo_RUN := EXAMPLE=cake
materials_RUN := EXAMPLE=six-materials AUTHORED=examples/six-materials-records.json
guitar_RUN := GAUSSIANS=$(GUITAR) UP=-y AZIMUTH=60 "PROMPT=the guitar falls onto the floor"
# What of the 800x800 pixels is shown, and how large.
demo_VIEW := scale=400:-2
materials_VIEW := crop=800:560:0:140,scale=480:-2
guitar_VIEW := crop=480:720:160:30,scale=-2:400

# Pages: file, width and height of the window, what is done in the page, and what is waited for.
PAGES := viewer report preview
page_viewer := viewer.html 1180 720 \
  "(async () => { while (viewer.state.loaded < header.frames.length) await new Promise(r => setTimeout(r, 50)); viewer.setPlaying(false); viewer.seek(20); viewer.orbit(-0.5, 0.06); })()" \
  "viewer.settled()"
page_report := report.html 1180 820
page_preview := preview.html 1180 740 "document.querySelector('[data-show=labels]').click(), document.querySelector('\#views').scrollIntoView()"

.PHONY: pictures-finished $(MOVING:%=picture-%) $(PAGES:%=page-%)
pictures-finished: $(MOVING:%=picture-%) $(PAGES:%=page-%)
	$(if $(GUITAR),,@echo "docs/images/guitar.webp stays as it is: GUITAR=guitar.compressed.ply makes it again.")

# All 50 frames at 25 per second; the last one stands for 0.8 s before the film begins again.
$(MOVING:%=picture-%): picture-%:
	+@$(MAKE) --no-print-directory run $($*_RUN) RUN=$(PICTURES)/$* PICTURES= GUITAR=
	ffmpeg -y -loglevel error -i $(PICTURES)/$*/final.mp4 \
	  -vf "fps=25,$($*_VIEW):flags=lanczos,tpad=stop_mode=clone:stop_duration=0.8" \
	  -c:v libwebp_anim -loop 0 -quality 75 -compression_level 6 docs/images/$*.webp

# Pages are those of the demo's run.
$(PAGES:%=page-%): page-%: picture-demo
	+@$(MAKE) --no-print-directory preview $(demo_RUN) RUN=$(PICTURES)/demo PICTURES= GUITAR=
	$(BIN)/pm-render --scene $(PICTURES)/demo/spec/render.json --state $(PICTURES)/demo/state.h5 --inventory $(PICTURES)/demo/inventory.json \
	  --rollout $(PICTURES)/demo/rollouts/$$(sed -n 's/^  "candidate": "\(.*\)",/\1/p' $(PICTURES)/demo/accepted.json).h5 \
	  --out $(PICTURES)/demo/viewer.mp4 --html $(PICTURES)/demo/viewer.html --quiet
	python3 tests/tools/page_picture.py $(PICTURES)/demo/$(firstword $(page_$*)) docs/images/page-$*.webp $(wordlist 2,999,$(page_$*))
