#!/usr/bin/env bats
# pm-lift as a user calls it.

load toy

setup_file() {
  make_bundle
  "$(bin)/pm-ground" --scene "$BATS_FILE_TMPDIR/toy/scene.json" --out "$BATS_FILE_TMPDIR/toy/run"
}
setup() {
  copy_bundle
  state=$BATS_TEST_TMPDIR/out/state.h5
}
lift() {
  run_tool pm-lift --scene "$scene/scene.json" --inventory "$scene/run/inventory.json" --masks "$scene/run/masks.h5" \
    --out "$state" "$@"
}
nothing_written() { [ ! -e "$BATS_TEST_TMPDIR/out" ] || [ -z "$(find "$BATS_TEST_TMPDIR/out" -type f)" ]; }

@test "pm-lift --help prints to stdout" {
  run_tool pm-lift --help
  [ "$status" -eq 0 ]
  [ -z "$errors" ]
  [[ "$output" == *"--labels-png"* ]]
}

@test "pm-lift without its options is a usage error" {
  run_tool pm-lift --out x
  expect_error 2 "pm-lift --help"
}

@test "pm-lift writes a state and pictures of the labels" {
  lift --labels-png "$BATS_TEST_TMPDIR/labels"
  [ "$status" -eq 0 ]
  [ -z "$errors" ]
  [ -s "$state" ]
  for view in front right back left; do [ -s "$BATS_TEST_TMPDIR/labels/$view.png" ]; done
}

@test "pm-lift again leaves the timestamp, whatever the number of threads" {
  lift --threads 1
  [ "$status" -eq 0 ]
  touch -d '2001-01-01' "$state"
  lift --threads 4
  [ "$status" -eq 0 ]
  [ -z "$(find "$state" -newermt 2001-01-02)" ]
}

@test "pm-lift refuses missing files" {
  for file in scene.json gaussians.ply run/inventory.json run/masks.h5; do
    mv "$scene/$file" "$scene/away"
    lift
    expect_error 3 "$(basename $file)"
    mv "$scene/away" "$scene/$file"
  done
  nothing_written
}

@test "pm-lift refuses cut Gaussians and cut masks" {
  head -c 2000 "$BATS_FILE_TMPDIR/toy/gaussians.ply" >"$scene/gaussians.ply"
  lift
  expect_error 3 "gaussians.ply"
  cp "$BATS_FILE_TMPDIR/toy/gaussians.ply" "$scene/gaussians.ply"
  head -c 5000 "$BATS_FILE_TMPDIR/toy/run/masks.h5" >"$scene/run/masks.h5"
  lift
  expect_error 3 "masks.h5"
  echo "no masks" >"$scene/run/masks.h5"
  lift
  expect_error 3 "masks.h5"
  nothing_written
}

@test "pm-lift refuses an inventory with malformed JSON, other rows, no residual row, a duplicate id" {
  printf '{' >"$scene/run/inventory.json"
  lift
  expect_error 3 "inventory.json"
  cp "$BATS_FILE_TMPDIR/toy/run/inventory.json" "$scene/run/inventory.json"
  edit_json "$scene/run/inventory.json" "d['rows'][0]['part'] = 'wheel'"
  lift
  expect_error 3 "unknown row key"
  cp "$BATS_FILE_TMPDIR/toy/run/inventory.json" "$scene/run/inventory.json"
  edit_json "$scene/run/inventory.json" "d['rows'].pop()"
  lift
  expect_error 3 "residual"
  cp "$BATS_FILE_TMPDIR/toy/run/inventory.json" "$scene/run/inventory.json"
  edit_json "$scene/run/inventory.json" "d['objects'].append(d['objects'][0])"
  lift
  expect_error 3 "/objects/1/id"
  nothing_written
}

@test "pm-lift refuses masks of another size than the camera" {
  edit_json "$scene/scene.json" "d['views'][0]['camera']['height'] = 77"
  lift
  expect_error 3 "77"
  nothing_written
}

@test "pm-lift lets some of more Gaussians than particles carry the others, but refuses fewer than rows" {
  edit_json "$scene/scene.json" "d['run']['particles'] = {'max': 200}"
  lift
  [ "$status" -eq 0 ]
  grep -aq "100 of [0-9]* Gaussians are particles and carry the others" "$state"
  rm "$state"
  edit_json "$scene/scene.json" "d['run']['particles'] = {'max': 2}"
  lift
  expect_error 3 "particles.max"
  nothing_written
}

@test "pm-lift refuses a folder that it cannot write" {
  echo x >"$BATS_TEST_TMPDIR/file"
  state=$BATS_TEST_TMPDIR/file/state.h5
  lift
  expect_error 3 "file"
}

@test "pm-lift: a chip that hangs apart from its row goes to what it touches, one in mid-air is reported, and both can be kept" {
  cd "$BATS_TEST_TMPDIR"
  cat >chips.json <<'J'
{"schema": "physmas/example/1", "name": "chips", "prompt": "the ball falls", "seed": 5, "spacing": 0.08,
 "objects": [
   {"id": "ball", "name": "ball", "parts": [{"part": "body", "name": "ball", "shapes": [
     {"type": "sphere", "radius": 0.5, "center": [0, 0, 1.8], "color": [0.9, 0.1, 0.1]},
     {"type": "sphere", "radius": 0.05, "center": [0.6, -0.53, 0.5], "color": [0.9, 0.1, 0.1]},
     {"type": "sphere", "radius": 0.05, "center": [-0.9, 0, 1.8], "color": [0.9, 0.1, 0.1]}]}]},
   {"id": "box", "name": "box", "parts": [{"part": "body", "name": "box", "shapes": [
     {"type": "box", "size": [2, 1, 1], "center": [0, 0, 0.5], "color": [0.1, 0.1, 0.9]}]}]}],
 "run": {"grid": {"n": 48}, "lifting": {"occlusion": "depth"}}}
J
  "$bin/pm-scene" synth chips.json --out chips --true-masks
  "$bin/pm-ground" --scene chips/scene.json --out run --perception masks:chips/true-masks
  chips() { # FLAG...
    "$bin/pm-scene" slice --scene chips/scene.json --out spec "$@"
    "$bin/pm-lift" --scene spec/lift.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5 2>errors
    "$bin/pm-eval" labels --scene chips/scene.json --inventory run/inventory.json --state run/state.h5 --out labels.json >table
  }
  chips
  cat errors
  [ "$(wc -l <errors)" -eq 1 ]
  grep -Eq 'given to what they touch: [1-9][0-9]* Gaussians \(1 pieces\); left, as they touch nothing: [1-9][0-9]* \(1\)' errors
  grep -aq 'islands of ball/body' run/state.h5
  grep -aq 'given to box/body' run/state.h5
  joined=$(grep row_accuracy labels.json)
  chips --set lifting.islands=keep
  [ ! -s errors ]
  refute grep -aq islands run/state.h5
  # The truth of this scene has the chips in the ball's row.
  [ "$(grep row_accuracy labels.json)" != "$joined" ]
}

@test "lift: a view whose masks contradict the others does not count, and is named; one without masks does not count either" {
  make_bundle
  cd "$BATS_TEST_TMPDIR"
  "$(bin)/pm-scene" synth "$BATS_FILE_TMPDIR/toy.json" --out scene --true-masks
  accuracy() { # MASKS
    rm -rf run
    "$(bin)/pm-ground" --scene scene/scene.json --out run --perception "masks:$1" 2>/dev/null
    "$(bin)/pm-lift" --scene scene/scene.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5 2>log
    "$(bin)/pm-eval" labels --scene scene/scene.json --inventory run/inventory.json --state run/state.h5 --out run/labels.json >/dev/null
    python3 -c 'import json; a = json.load(open("run/labels.json"))["row_accuracy"]; print(a); assert a > 0.97, a'
  }
  spoil=${PM_TEST_BIN:-$(bin)/../test}/spoil_masks
  for kind in "swapped 1" "missing 1" "missing 2" "medium 1"; do
    rm -rf spoilt
    "$spoil" scene/true-masks spoilt $kind
    accuracy spoilt
    if [ "$kind" = "swapped 1" ]; then
      grep -q "the masks of the view back contradict those of the other views" log
    else
      refute grep -q contradict log
    fi
  done
  rm -rf spoilt run
  "$spoil" scene/true-masks spoilt swapped 2
  "$(bin)/pm-ground" --scene scene/scene.json --out run --perception masks:spoilt 2>/dev/null
  "$(bin)/pm-lift" --scene scene/scene.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5 2>log
  grep -q "the masks of the views .* contradict each other; the labels may be wrong" log
}
