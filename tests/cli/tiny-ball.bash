# A ball of a few Gaussians as a bundle: sets BIN and TINY. For setup_file.
make_tiny_ball() {
  export BIN="${PM_BIN:-build/bin}"
  export TINY="$BATS_FILE_TMPDIR/tiny"
  cat > "$BATS_FILE_TMPDIR/tiny.json" <<'JSON'
{"schema": "physmas/example/1", "name": "tiny", "prompt": "it falls", "spacing": 0.15, "floor": {"height": -0.2},
 "objects": [{"id": "ball", "name": "ball", "parts": [{"part": "body", "name": "ball", "shapes": [
   {"type": "sphere", "radius": 0.5, "color": [0.9, 0.3, 0.1]}]}]}],
 "run": {"grid": {"n": 32}, "render": {"width": 64, "height": 64}}}
JSON
  "$BIN/pm-scene" synth "$BATS_FILE_TMPDIR/tiny.json" --out "$TINY"
}
