#!/usr/bin/env bats
# pm-ground as a user calls it.

load toy

setup_file() { make_bundle; }
setup() {
  copy_bundle
  out=$BATS_TEST_TMPDIR/run
}
ground() { run_tool pm-ground --scene "$scene/scene.json" --out "$out" "$@"; }
nothing_written() { [ ! -e "$out" ] || [ -z "$(find "$out" -type f)" ]; }

@test "pm-ground --help prints to stdout" {
  run_tool pm-ground --help
  [ "$status" -eq 0 ]
  [ -z "$errors" ]
  [[ "$output" == *"--perception"* ]]
}

@test "pm-ground without its options is a usage error" {
  run_tool pm-ground
  expect_error 2 "--scene"
}

@test "pm-ground writes inventory, plan and masks" {
  ground
  [ "$status" -eq 0 ]
  [ "$(grep -vc '^pm-ground: note: the prompt: ' <<<"$errors")" -eq 0 ]
  grep -q '"target": "toy/ball"' "$out/plan.json"
  grep -q '"part": "residual"' "$out/inventory.json"
  [ -s "$out/masks.h5" ]
}

@test "pm-ground again leaves the timestamps" {
  ground
  touch -d '2001-01-01' "$out"/*
  ground --threads 1
  [ "$status" -eq 0 ]
  [ -z "$(find "$out" -type f -newermt 2001-01-02)" ]
}

@test "pm-ground without an inventory takes the prompt's noun" {
  edit_json "$scene/scene.json" "del d['inventory']; d['prompt'] = 'the toy falls onto the floor'"
  ground
  [ "$status" -eq 0 ]
  grep -q '"id": "toy"' "$out/inventory.json"
  grep -q '"actions": \[\]' "$out/plan.json"
}

@test "pm-ground reads mask files" {
  masks=$BATS_TEST_TMPDIR/masks
  for view in front right back left; do
    mkdir -p "$masks/$view/toy"
    cp "$scene/views/$view.png" "$masks/$view/toy.png"
    cp "$scene/views/$view.png" "$masks/$view/toy/ball.png"
  done
  ground --perception "masks:$masks"
  [ "$status" -eq 0 ]
  rm -r "$out"
  cp "$scene/views/front.png" "$masks/front/toy/wheel.png"
  ground --perception "masks:$masks"
  expect_error 3 "wheel.png"
  nothing_written
  rm "$masks/front/toy/wheel.png"
  mkdir "$masks/above"
  ground --perception "masks:$masks"
  expect_error 3 "above"
  ground --perception "masks:$BATS_TEST_TMPDIR/nowhere"
  expect_error 3 "nowhere"
}

@test "pm-ground refuses a missing file" {
  rm "$scene/scene.json"
  ground
  expect_error 3 "scene.json"
  nothing_written
}

@test "pm-ground refuses a missing or broken view" {
  rm "$scene/views/back.png"
  ground
  expect_error 3 "back.png"
  echo "no image" >"$scene/views/back.png"
  ground
  expect_error 3 "back.png"
  head -c 300 "$scene/views/front.png" >"$scene/views/back.png"
  ground
  expect_error 3 "back.png"
  nothing_written
}

@test "pm-ground refuses malformed JSON, another schema, an unknown field" {
  printf '{"schema": ' >"$scene/scene.json"
  ground
  expect_error 3 "scene.json"
  cp "$BATS_FILE_TMPDIR/toy/scene.json" "$scene/scene.json"
  edit_json "$scene/scene.json" "d['schema'] = 'physmas/plan/1'"
  ground
  expect_error 3 "/schema"
  cp "$BATS_FILE_TMPDIR/toy/scene.json" "$scene/scene.json"
  edit_json "$scene/scene.json" "d['colour'] = 1"
  ground
  expect_error 3 "colour"
  nothing_written
}

@test "pm-ground refuses a blank prompt, three views, an image of another size" {
  edit_json "$scene/scene.json" "d['prompt'] = '  '"
  ground
  expect_error 3 "/prompt"
  cp "$BATS_FILE_TMPDIR/toy/scene.json" "$scene/scene.json"
  edit_json "$scene/scene.json" "d['views'].pop()"
  ground
  expect_error 3 "/views"
  cp "$BATS_FILE_TMPDIR/toy/scene.json" "$scene/scene.json"
  edit_json "$scene/scene.json" "d['views'][1]['camera']['width'] = 99"
  ground
  expect_error 3 "99 x"
  nothing_written
}

@test "pm-ground refuses duplicate ids in an authored inventory" {
  edit_json "$scene/inventory.json" "d['rows'].append(d['rows'][0])"
  ground
  expect_error 3 "/part"
  nothing_written
}

@test "pm-ground refuses a thing that is not there" {
  edit_json "$scene/scene.json" "d['prompt'] = 'push the piano'"
  ground
  expect_error 3 "toy/box"
  nothing_written
}

@test "pm-ground refuses a folder that it cannot write" {
  echo x >"$BATS_TEST_TMPDIR/file"
  run_tool pm-ground --scene "$scene/scene.json" --out "$BATS_TEST_TMPDIR/file/run"
  expect_error 3 "file"
}

@test "pm-ground refines its masks with GrabCut, says so, and leaves it when the run says so" {
  ground
  grep -aq "hints, GrabCut" "$out/masks.h5"
  rm -r "$out"
  edit_json "$scene/scene.json" "d['run']['segmentation'] = {'grabcut': False}"
  ground
  [ "$status" -eq 0 ]
  refute grep -aq GrabCut "$out/masks.h5"
  grep -aq hints "$out/masks.h5"
}

@test "pm-ground warns of words that it does not understand" {
  edit_json "$scene/scene.json" "d['prompt'] = 'push the ball to the left, frobnicate the box'"
  ground
  [ "$status" -eq 0 ]
  [[ "$errors" == *"not understood"*"frobnicate"* ]]
  grep -q '"not understood.*frobnicate' "$out/plan.json"
}

@test "pm-ground takes a given plan in place of what the prompt says, and refuses one that is none" {
  ground
  sed 's/"magnitude": .*,/"magnitude": 0.123,/' "$out/plan.json" >"$BATS_TEST_TMPDIR/mine.json"
  ground --plan "$BATS_TEST_TMPDIR/mine.json"
  [ "$status" -eq 0 ]
  [[ "$errors" == *"the actions are those of a plan that was given"* ]]
  grep -q '"magnitude": 0.123' "$out/plan.json"
  grep -q 'mine.json' "$out/plan.json"
  rm -r "$out"
  sed -i 's/"top_press"\|"translation"\|"impulse"/"fly"/' "$BATS_TEST_TMPDIR/mine.json"
  ground --plan "$BATS_TEST_TMPDIR/mine.json"
  expect_error 3 mine.json
  nothing_written
  ground --plan missing.json
  expect_error 3 missing.json
}
