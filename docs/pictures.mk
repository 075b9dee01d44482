# The moving pictures of README.md and docs/, from runs: make pictures GUITAR=guitar.compressed.ply. Needs ffmpeg (Debian's
# package of that name). The guitar's file is no part of this project (docs/start.md says where it is from); without it its
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

.PHONY: pictures-finished $(MOVING:%=picture-%)
pictures-finished: $(MOVING:%=picture-%)
	$(if $(GUITAR),,@echo "docs/images/guitar.webp stays as it is: GUITAR=guitar.compressed.ply makes it again.")

# All 50 frames at 25 per second; the last one stands for 0.8 s before the film begins again.
$(MOVING:%=picture-%): picture-%:
	+@$(MAKE) --no-print-directory run $($*_RUN) RUN=$(PICTURES)/$* PICTURES= GUITAR=
	ffmpeg -y -loglevel error -i $(PICTURES)/$*/final.mp4 \
	  -vf "fps=25,$($*_VIEW):flags=lanczos,tpad=stop_mode=clone:stop_duration=0.8" \
	  -c:v libwebp_anim -loop 0 -quality 75 -compression_level 6 docs/images/$*.webp
