# Shared by the tests of pm-ground and pm-lift: a toy bundle, and ways to damage it.
load common
bin() { echo "${PM_BIN:-$BATS_TEST_DIRNAME/../../build/bin}"; }

# run_tool TOOL ARGS...: as bats' run, with stdout in $output and stderr in $errors.
run_tool() {
  local tool=$1
  shift
  status=0
  output=$("$(bin)/$tool" "$@" 2>"$BATS_TEST_TMPDIR/errors") || status=$?
  errors=$(cat "$BATS_TEST_TMPDIR/errors")
}

# expect_error CODE PATTERN: that exit code, nothing on stdout, one line on stderr that has PATTERN.
expect_error() {
  [ "$status" -eq "$1" ] || { echo "exit $status, expected $1: $errors"; return 1; }
  [ -z "$output" ] || { echo "stdout: $output"; return 1; }
  [ "$(wc -l <"$BATS_TEST_TMPDIR/errors")" -eq 1 ] || { echo "not one line: $errors"; return 1; }
  grep -q -e "$2" "$BATS_TEST_TMPDIR/errors" || { echo "no '$2' in: $errors"; return 1; }
}

# A small bundle: a red ball on a blue box, four views of 64 x 64 pixels.
make_bundle() {
  cat >"$BATS_FILE_TMPDIR/toy.json" <<'JSON'
{"schema": "physmas/example/1", "name": "toy", "prompt": "push the ball to the left", "seed": 5, "spacing": 0.1,
 "floor": {"height": -0.5},
 "objects": [{"id": "toy", "name": "toy", "parts": [
   {"part": "ball", "name": "ball", "shapes": [
     {"type": "sphere", "radius": 0.5, "center": [0, 0, 1.5], "color": [0.9, 0.1, 0.1]}]},
   {"part": "box", "name": "box", "shapes": [
     {"type": "box", "size": [2, 1, 1], "center": [0, 0, 0.5], "color": [0.1, 0.1, 0.9]}]}]}],
 "run": {"grid": {"n": 32}, "lifting": {"occlusion": "depth"}}}
JSON
  "$(bin)/pm-scene" synth "$BATS_FILE_TMPDIR/toy.json" --out "$BATS_FILE_TMPDIR/toy"
}

# A copy of the bundle that a test may damage: $scene is its folder.
copy_bundle() {
  scene=$BATS_TEST_TMPDIR/scene
  cp -r "$BATS_FILE_TMPDIR/toy" "$scene"
}

# edit_json FILE PYTHON: runs a statement on the document `d`.
edit_json() {
  python3 - "$1" "$2" <<'PY'
import json, sys
d = json.load(open(sys.argv[1]))
exec(sys.argv[2])
json.dump(d, open(sys.argv[1], "w"))
PY
}
