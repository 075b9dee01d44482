#!/usr/bin/env bats
# The adapters of examples/servers/models.py with random weights (tests/servers/tiny_weights.py) through transformers, from KServe's
# model server: `make test-servers`.
bats_require_minimum_version 1.5.0
load real
load_from_cli server

teardown() { end_server; }

@test "real: Grounding DINO, SAM 2, CLIP and CoTracker3's adapters answer what a run asks" {
  cd "$BATS_TEST_TMPDIR"
  export HF_HUB_OFFLINE=1 OMP_NUM_THREADS=2
  "$PM_SERVERS/kserve/bin/python" "$BATS_TEST_DIRNAME/tiny_weights.py" weights 2>log || { cat log; return 1; }
  start_server kserve serve_kserve.py models:GroundingDino models:Sam2 models:ClipText models:ClipImage models:CoTracker3 \
    --weights grounding-dino=weights/dino sam2=weights/sam2 clip-text=weights/clip-text clip-image=weights/clip-image cotracker3=weights/co-tracker
  is_ready grounding-dino sam2 clip-text clip-image cotracker3
  check() { "$bin/pm-ground" check --timeout 300 "$1" --exchanges kept >said || { cat said; tail -n 20 server.log; return 1; }; cat said; }
  check "$server_url"
  grep -qE 'ok +grounding-dino +answers .*boxes \[[0-9]+, 4\]' said
  grep -qE 'ok +sam2 +answers .*masks \[1, 64, 64\]' said
  check "$url/clip-text"
  grep -qE 'answers .*text_embeds \[1, 16\]' said
  check "$url/clip-image"
  grep -qE 'answers .*image_embeds \[1, 16\]' said
  check "$url/cotracker3"
  grep -qE 'answers .*tracks \[1, 2, 1, 2\], visibility \[1, 2, 1\]' said
}
