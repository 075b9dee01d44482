#!/usr/bin/env bats
# pm-scene as a user calls it.

bats_require_minimum_version 1.5.0

load tiny-ball

setup_file() {
  make_tiny_ball
}

setup() {
  OUT="$BATS_TEST_TMPDIR/out"
  DATA="../shared/data"
}

# refused EXIT TEXT COMMAND...: that exit code, nothing on stdout, one line on stderr that holds TEXT.
refused() {
  local code="$1" text="$2" status=0
  shift 2
  "$@" > "$BATS_TEST_TMPDIR/stdout" 2> "$BATS_TEST_TMPDIR/stderr" || status=$?
  cat "$BATS_TEST_TMPDIR/stderr"
  [ "$status" -eq "$code" ]
  [ ! -s "$BATS_TEST_TMPDIR/stdout" ]
  [ "$(wc -l < "$BATS_TEST_TMPDIR/stderr")" -eq 1 ]
  grep -qF -- "$text" "$BATS_TEST_TMPDIR/stderr"
}

# The same for an input that is wrong, and nothing was written.
refused_input() {
  refused 3 "$@"
  [ ! -e "$OUT" ]
}

import() {
  "$BIN/pm-scene" import "$@" --out "$OUT"
}

# cameras COUNT: a list of COUNT views over the images of the tiny bundle.
cameras() {
  local name comma="["
  for name in $(echo front right back left | cut -d' ' -f"1-$1"); do
    echo "$comma{\"name\": \"$name\", \"image\": \"$name.png\", \"camera\": {\"width\": 640, \"height\": 640, \"fx\": 800, \"fy\": 800,"
    echo "\"cx\": 320, \"cy\": 320, \"world_to_camera\": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}"
    comma=","
  done
  echo "]"
}

@test "help and version go to stdout with exit 0" {
  run --separate-stderr "$BIN/pm-scene" --help
  [ "$status" -eq 0 ]
  [[ "$output" == *synth* && "$output" == *import* && "$output" == *slice* ]]
  [ -z "$stderr" ]
  run "$BIN/pm-scene" import --help
  [ "$status" -eq 0 ]
  [[ "$output" == *--prompt* ]]
  run "$BIN/pm-scene" --version
  [ "$status" -eq 0 ]
}

@test "usage errors exit 2" {
  refused 2 "subcommand" "$BIN/pm-scene"
  refused 2 "--out" "$BIN/pm-scene" synth examples/cake.json
  refused 2 "--prompt" import "$TINY/gaussians.ply"
  refused 2 "--up" import "$TINY/gaussians.ply" --prompt x --up q
  refused 2 "--cameras" import "$TINY/gaussians.ply" --prompt x --views "$TINY/views"
  refused 2 "--device cuda: pm-scene computes on the CPU only" "$BIN/pm-scene" --device cuda info "$TINY/gaussians.ply"
  [ ! -e "$OUT" ]
}

@test "synth writes a whole bundle, silently" {
  run "$BIN/pm-scene" synth examples/cake.json --out "$OUT"
  [ "$status" -eq 0 ]
  [ -z "$output" ]
  for f in gaussians.ply inventory.json truth.h5 scene.json views/front.png views/right.png views/back.png views/left.png; do
    [ -s "$OUT/$f" ]
  done
  run "$BIN/pm-scene" info "$OUT/scene.json"
  [ "$status" -eq 0 ]
  [[ "$output" == *"row       cake/strawberries"* ]]
}

@test "every example can be synthesised" {
  examples=$(grep -l '"physmas/example/1"' examples/*.json)
  for e in $examples; do "$BIN/pm-scene" synth "$e" --out "$BATS_TEST_TMPDIR/$(basename "$e" .json)"; done
}

@test "the bytes do not depend on the number of threads" {
  "$BIN/pm-scene" --threads 1 synth "$BATS_FILE_TMPDIR/tiny.json" --out "$BATS_TEST_TMPDIR/one"
  "$BIN/pm-scene" --threads 2 synth "$BATS_FILE_TMPDIR/tiny.json" --out "$BATS_TEST_TMPDIR/two"
  diff -r "$BATS_TEST_TMPDIR/one" "$BATS_TEST_TMPDIR/two"
}

@test "a rerun on unchanged input keeps every timestamp" {
  import "$TINY/gaussians.ply" --prompt "it falls" --up z
  before="$(find "$OUT" -type f -printf '%p %T@\n' | sort)"
  import "$TINY/gaussians.ply" --prompt "it falls" --up z
  [ "$before" = "$(find "$OUT" -type f -printf '%p %T@\n' | sort)" ]
  [ -z "$(find "$OUT" -name '.*.tmp*')" ]
}

@test "import keeps the Gaussians bit for bit, adds a floor and names the scene after the file" {
  cp "$TINY/gaussians.ply" "$BATS_TEST_TMPDIR/My Ball.ply"
  import "$BATS_TEST_TMPDIR/My Ball.ply" --prompt "it falls" --up -y --drop 0.2
  cmp "$TINY/gaussians.ply" "$OUT/gaussians.ply"
  run "$BIN/pm-scene" info "$OUT/scene.json"
  [[ "$output" == *"scene my-ball"* && "$output" == *"up -y, 1 colliders"* ]]
}

@test "import takes the user's own views, inventory, masks and run specification" {
  cameras 4 > "$BATS_TEST_TMPDIR/cameras.json"
  mkdir -p "$BATS_TEST_TMPDIR/masks/front"
  cp "$TINY/views/front.png" "$BATS_TEST_TMPDIR/masks/front/ball.png"
  echo '{"schema": "physmas/run/1", "grid": {"n": 40}, "time": {"frames": 10}}' > "$BATS_TEST_TMPDIR/run.json"
  import "$TINY/gaussians.ply" --prompt "it falls" --up z --views "$TINY/views" --cameras "$BATS_TEST_TMPDIR/cameras.json" \
    --inventory "$TINY/inventory.json" --masks "$BATS_TEST_TMPDIR/masks" --run "$BATS_TEST_TMPDIR/run.json" --name mine
  cmp "$TINY/views/left.png" "$OUT/views/left.png"
  cmp "$TINY/inventory.json" "$OUT/inventory.json"
  [ -s "$OUT/masks/front/ball.png" ]
  run "$BIN/pm-scene" info "$OUT/scene.json"
  [[ "$output" == *"scene mine"* && "$output" == *"for 10 frames"* && "$output" == *"40 cells"* ]]
}

@test "import leaves the grid to its rule, and says when the user's own is too fine for the steps" {
  quick=$BATS_TEST_DIRNAME/../../examples/quick-run.json
  import "$TINY/gaussians.ply" --prompt "it falls" --run "$quick" 2>"$BATS_TEST_TMPDIR/errors"
  [ ! -s "$BATS_TEST_TMPDIR/errors" ]
  [ "$(sed -nE 's/.*"n": ([0-9]+).*/\1/p' "$OUT/scene.json")" -le 37 ]
  echo '{"schema": "physmas/run/1", "grid": {"n": 48}, "time": {"min_substep_dt": 1e-4, "max_substeps": 400}}' >"$BATS_TEST_TMPDIR/run.json"
  import "$TINY/gaussians.ply" --prompt "it falls" --run "$BATS_TEST_TMPDIR/run.json" 2>"$BATS_TEST_TMPDIR/errors"
  [ "$(wc -l <"$BATS_TEST_TMPDIR/errors")" -eq 1 ]
  grep -q "run.json: grid.n = 48.* at most 37 cells" "$BATS_TEST_TMPDIR/errors"
  grep -q '"n": 48' "$OUT/scene.json"
}

@test "import --front turns the views: an axis, degrees, a view's name; left and right follow" {
  first_axis() { python3 -c "import json,sys; print([round(v, 6) + 0 for v in json.load(open('$OUT/scene.json'))['views'][0]['camera']['world_to_camera'][0][:3]])"; }
  import "$TINY/gaussians.ply" --prompt x --up z
  [ "$(first_axis)" = "[1.0, 0.0, 0.0]" ]
  grep -q '"camera": "fit"' "$OUT/scene.json"
  import "$TINY/gaussians.ply" --prompt x --up z --front x
  [ "$(first_axis)" = "[0.0, 1.0, 0.0]" ]
  grep -q '"front": "x"' "$OUT/scene.json"
  before="$(sed '/"front": "/d' "$OUT/scene.json")"
  import "$TINY/gaussians.ply" --prompt x --up z --front 90
  [ "$(sed '/"front": "/d' "$OUT/scene.json")" = "$before" ]
  import "$TINY/gaussians.ply" --prompt x --up z --front=-x
  [ "$(first_axis)" = "[0.0, -1.0, 0.0]" ]
  # Of views of the user's own the nearest, or the one that is named, comes first.
  python3 - "$OUT/scene.json" > "$BATS_TEST_TMPDIR/cameras.json" <<'PY'
import json, sys
print(json.dumps([{**v, "image": v["image"].removeprefix("views/")} for v in json.load(open(sys.argv[1]))["views"]]))
PY
  cp -r "$OUT/views" "$BATS_TEST_TMPDIR/views"
  own() { import "$TINY/gaussians.ply" --prompt x --up z --views "$BATS_TEST_TMPDIR/views" --cameras "$BATS_TEST_TMPDIR/cameras.json" "$@"; }
  own --front x
  [ "$(first_axis)" = "[0.0, 1.0, 0.0]" ]
  own --front right
  [ "$(first_axis)" = "[1.0, 0.0, 0.0]" ]
  rm -r "$OUT"
  refused 2 "--front" own --front nowhere
  refused 2 "--front" import "$TINY/gaussians.ply" --prompt x --up z --front z
  refused 2 "--cameras" import "$TINY/gaussians.ply" --prompt x --up z --front nowhere
  [ ! -e "$OUT" ]
}

@test "what stands in a capture carries its weight from the start, unless the run specification says otherwise" {
  import "$TINY/gaussians.ply" --prompt "it stands" --up z --drop 0
  grep -q '"start": "equilibrium"' "$OUT/scene.json"
  # Few particles may be simulated for longer when it is done again.
  [ "$(grep -oP '"retry_substeps": \K[0-9]+' "$OUT/scene.json")" -gt 40000 ]
  heights() { grep -A4 -E '"(center|point)"' "$OUT/scene.json"; }
  standing="$(heights)"
  import "$TINY/gaussians.ply" --prompt "it stands" --up z
  [ "$(heights)" = "$standing" ]
  import "$TINY/gaussians.ply" --prompt "it falls" --up z
  [ "$(heights)" != "$standing" ]
  echo '{"schema": "physmas/run/1", "time": {"start": "rest"}}' > "$BATS_TEST_TMPDIR/run.json"
  import "$TINY/gaussians.ply" --prompt "it stands" --up z --drop 0 --run "$BATS_TEST_TMPDIR/run.json"
  grep -q '"start": "rest"' "$OUT/scene.json"
}

@test "import says how many Gaussians are simulated when they are more than the particles" {
  echo '{"schema": "physmas/run/1", "particles": {"max": 50}}' >"$BATS_TEST_TMPDIR/run.json"
  import "$TINY/gaussians.ply" --prompt "it falls" --run "$BATS_TEST_TMPDIR/run.json" 2>"$BATS_TEST_TMPDIR/errors"
  grep -q "Gaussians are more than particles.max = 50: 25 of them are simulated and carry the others" "$BATS_TEST_TMPDIR/errors"
}

@test "import refuses an inventory whose views and labels do not exist" {
  for change in 's/"expected_labels": \[/&"Rubbr", /' 's/"structural_role"/"hints": {"regions": {"fron": [[[0, 0], [1, 0], [1, 1]]]}}, "structural_role"/'; do
    python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); [r.update(expected_labels=["Rubber"]) or r.pop("hints", 0) for r in d["rows"]]; json.dump(d, sys.stdout)' \
      "$TINY/inventory.json" | sed "$change" >"$BATS_TEST_TMPDIR/inventory.json"
    expected=Plasticine
    [[ $change = *Rubbr* ]] || expected="a view of the scene: front, right, back, left"
    refused_input "$expected" import "$TINY/gaussians.ply" --prompt "it falls" --inventory "$BATS_TEST_TMPDIR/inventory.json"
  done
}

@test "bad prompts, files and names are refused and nothing is written" {
  refused_input "--prompt" import "$TINY/gaussians.ply" --prompt "  "
  refused_input "nowhere.ply" import "$BATS_TEST_TMPDIR/nowhere.ply" --prompt x
  head -c 1000 "$TINY/gaussians.ply" > "$BATS_TEST_TMPDIR/cut.ply"
  refused_input "cut.ply" import "$BATS_TEST_TMPDIR/cut.ply" --prompt x
  echo "no Gaussians" > "$BATS_TEST_TMPDIR/text.ply"
  refused_input "text.ply" import "$BATS_TEST_TMPDIR/text.ply" --prompt x
  refused 2 "--name" import "$TINY/gaussians.ply" --prompt x --name "Not An Id"
  refused_input "--drop" import "$TINY/gaussians.ply" --prompt x --drop 1
}

@test "wrong views are refused and nothing is written" {
  local c="$BATS_TEST_TMPDIR/cameras.json"
  user_views() { import "$TINY/gaussians.ply" --prompt x --views "$TINY/views" --cameras "$c"; }
  cameras 3 > "$c"
  refused_input "3 views" user_views
  cameras 4 | sed 's/"width": 640/"width": 320/' > "$c"
  refused_input "640 x 640" user_views
  cameras 4 | sed 's/"right"/"front"/' > "$c"
  refused_input "/1/name" user_views
  cameras 4 | sed 's/left.png/missing.png/' > "$c"
  refused_input "missing.png" user_views
  cameras 4 | sed 's/left.png/..\/views\/left.png/' > "$c"
  refused_input "/3/image" user_views
  echo '{"views": []}' > "$c"
  refused_input "a list of four" user_views
  echo '[{"name": ' > "$c"
  refused_input "malformed JSON" user_views
}

@test "wrong authored files are refused and nothing is written" {
  local f="$BATS_TEST_TMPDIR/file.json"
  with() { import "$TINY/gaussians.ply" --prompt x --up z "$@"; }
  echo '{"schema": "physmas/run/1", "grid": {"m": 40}}' > "$f"
  refused_input "/grid" with --run "$f"
  echo '{"schema": "physmas/run/1", "placement": {"up": "x"}}' > "$f"
  refused_input "/placement/up" with --run "$f"
  echo '{"schema": "physmas/inventory/1", "objects": [{"id": "a", "name": "a"}], "rows": [{"object": "b", "part": "p", "name": "p"}]}' > "$f"
  refused_input "/rows/0/object" with --inventory "$f"
  mkdir -p "$BATS_TEST_TMPDIR/masks/top"
  cp "$TINY/views/front.png" "$BATS_TEST_TMPDIR/masks/top/ball.png"
  refused_input "a mask of no view" with --masks "$BATS_TEST_TMPDIR/masks"
  refused_input "a folder with masks" with --masks "$BATS_TEST_TMPDIR/no-masks"
}

@test "wrong examples are refused and nothing is written" {
  synth() { sed "$1" "$BATS_FILE_TMPDIR/tiny.json" > "$BATS_TEST_TMPDIR/e.json"; "$BIN/pm-scene" synth "$BATS_TEST_TMPDIR/e.json" --out "$OUT"; }
  refused_input "/objects/0/parts/0/shapes/0/radius" synth 's/"radius": 0.5, //'
  refused_input "sphere takes radius" synth 's/"radius": 0.5/"radius": 0.5, "size": [1, 1, 1]/'
  refused_input "/prompt" synth 's/it falls/ /'
  refused_input "physmas/example/1" synth 's/physmas.example.1/physmas\/scene\/1/'
  refused_input "/floor/height" synth 's/"height": -0.2/"height": -9/'
  refused_input "line 1" synth 's/^{/{{/'
}

@test "a folder that cannot be written, or a full disk, is an error without half files" {
  echo file > "$BATS_TEST_TMPDIR/occupied"
  refused 3 "occupied" "$BIN/pm-scene" synth "$BATS_FILE_TMPDIR/tiny.json" --out "$BATS_TEST_TMPDIR/occupied/scene"
  refused 3 "/proc/nowhere" "$BIN/pm-scene" synth "$BATS_FILE_TMPDIR/tiny.json" --out /proc/nowhere
  mkdir "$BATS_TEST_TMPDIR/small"
  mount -t tmpfs -o size=64k none "$BATS_TEST_TMPDIR/small" 2> /dev/null || skip "no full disk: tmpfs cannot be mounted here"
  status=0
  "$BIN/pm-scene" synth examples/cake.json --out "$BATS_TEST_TMPDIR/small/scene" 2> "$BATS_TEST_TMPDIR/stderr" || status=$?
  left="$(find "$BATS_TEST_TMPDIR/small" -type f)"
  umount "$BATS_TEST_TMPDIR/small"
  [ "$status" -eq 3 ]
  [ "$(wc -l < "$BATS_TEST_TMPDIR/stderr")" -eq 1 ]
  grep -q "No space left" "$BATS_TEST_TMPDIR/stderr"
  [ -z "$left" ]
}

@test "slices change only where the setting reaches" {
  slice() { "$BIN/pm-scene" slice --scene "$TINY/scene.json" --out "$OUT" "$@"; }
  slice
  [ "$(ls "$OUT" | wc -l)" -eq 7 ]
  before="$(find "$OUT" -type f -printf '%f %T@\n' | sort)"
  slice --set screening.tau=0.6
  changed="$(comm -13 <(echo "$before") <(find "$OUT" -type f -printf '%f %T@\n' | sort) | cut -d' ' -f1)"
  [ "$changed" = screen.json ]
  slice --set time.frames=20 --set screening.tau=0.5
  grep -q '"frames": 20' "$OUT/simulate.json"
  # What the scene says wins over --default, --set over both; a fitted camera is a fact for make.
  slice --default time.frames=20 --default render.camera=fit --default render.floor=shadow
  [ "$(grep -c '"frames": 20' "$OUT/simulate.json")" -eq 0 ]
  grep -q '"camera": "fit"' "$OUT/render.json"
  grep -q '"colliders"' "$OUT/render.json"
  grep -qx 'PM_CAMERA := fit' "$OUT/camera.mk"
  slice --default render.camera=fit --set render.camera=fixed
  [ "$(grep -c '"colliders"' "$OUT/render.json")" -eq 0 ]
  [ ! -e "$OUT/camera.mk" ]
  refused 2 "/render/camera" slice --set render.camera=near
  refused 2 "--set" slice --set tau
  refused 2 "/screening" slice --set screening.tua=1
  echo '{"schema": "physmas/run/1", "time": {"frames": 0}}' > "$BATS_TEST_TMPDIR/o.json"
  refused 3 "/time/frames" slice --overrides "$BATS_TEST_TMPDIR/o.json"
}

@test "the real guitar is imported with its authored inventory" {
  [ -f "$DATA/guitar.compressed.ply" ] || skip "no $DATA/guitar.compressed.ply"
  import "$DATA/guitar.compressed.ply" --up -y --prompt "the guitar falls onto the floor" --inventory examples/guitar-inventory.json
  run "$BIN/pm-scene" info "$OUT/scene.json"
  [[ "$output" == *"90854 Gaussians"* && "$output" == *"guitar/headstock"* && "$output" == *"stand/stand"* ]]
}

@test "a standard PLY with spherical harmonics of degree 3 is imported" {
  [ -f "$DATA/udon.ply" ] || skip "no $DATA/udon.ply"
  import "$DATA/udon.ply" --prompt "the food falls onto the floor"
  run "$BIN/pm-scene" info "$OUT/gaussians.ply"
  [[ "$output" == *"2153 Gaussians"* && "$output" == *"degree 3"* ]]
}
