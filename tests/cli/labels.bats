#!/usr/bin/env bats
# pm-eval labels: the toy's labels against the truth in its bundle.
bats_require_minimum_version 1.5.0
load toy

setup_file() { make_bundle; }
setup() {
  copy_bundle
  cd "$BATS_TEST_TMPDIR" || return 1
  "$bin/pm-ground" --scene scene/scene.json --out run
  "$bin/pm-lift" --scene scene/scene.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5
}
labels() { "$bin/pm-eval" labels --scene scene/scene.json --inventory run/inventory.json --state run/state.h5 --out labels.json "$@"; }

@test "labels: the built-in segmenter gets the toy's ball and box right, and the table adds up" {
  labels >table
  grep -q "toy/ball" table
  python3 - <<'PY'
import json
d = json.load(open("labels.json"))
assert d["row_accuracy"] >= 0.97 and d["object_accuracy"] == 1, d
assert sum(sum(row["labelled"]) for row in d["confusion"]) == d["gaussians"]
right = sum(row["labelled"][d["labels"].index(row["key"])] for row in d["confusion"])
assert abs(right / d["gaussians"] - d["row_accuracy"]) < 1e-12
PY
}

@test "labels: cake and sunflower reach 0.97 with the built-in segmenter and 0.99 with true masks" {
  for name in cake sunflower; do
    "$bin/pm-scene" synth "$root/examples/$name.json" --out $name --true-masks
    for case in "builtin 0.97" "masks:$name/true-masks 0.99"; do
      "$bin/pm-ground" --scene $name/scene.json --out run --perception "${case% *}"
      "$bin/pm-lift" --scene $name/scene.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5
      "$bin/pm-eval" labels --scene $name/scene.json --inventory run/inventory.json --state run/state.h5 --out labels.json
      python3 -c 'import json, sys; a = json.load(open("labels.json"))["row_accuracy"]; assert a >= float(sys.argv[1]), a' "${case#* }"
    done
  done
}

@test "labels: a bundle without truth, and a truth of another scene" {
  rm scene/truth.h5
  fails_with 3 labels -- truth.h5
  cp run/state.h5 scene/truth.h5
  fails_with 3 labels -- truth.h5 physmas/truth
  [ ! -e labels.json ]
}

@test "labels: masks of nothing, of everything and of another object degrade the labels gracefully and are reported" {
  cat >pair.json <<'JSON'
{"schema": "physmas/example/1", "name": "pair", "prompt": "the ball falls", "seed": 5, "spacing": 0.1,
 "objects": [
   {"id": "ball", "name": "ball", "parts": [{"part": "body", "name": "ball", "shapes": [
     {"type": "sphere", "radius": 0.5, "center": [0, 0, 1.8], "color": [0.9, 0.1, 0.1]}]}]},
   {"id": "box", "name": "box", "parts": [{"part": "body", "name": "box", "shapes": [
     {"type": "box", "size": [2, 1, 1], "center": [0, 0, 0.5], "color": [0.1, 0.1, 0.9]}]}]}],
 "run": {"grid": {"n": 32}, "lifting": {"occlusion": "depth"}}}
JSON
  "$bin/pm-scene" synth pair.json --out pair --true-masks
  accuracy() { # AT_LEAST: of the labels by pair/true-masks; what pm-ground said is in log
    "$bin/pm-ground" --scene pair/scene.json --out run --perception masks:pair/true-masks --log-level info 2>log
    "$bin/pm-lift" --scene pair/scene.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5
    "$bin/pm-eval" labels --scene pair/scene.json --inventory run/inventory.json --state run/state.h5 --out labels.json
    python3 -c 'import json, sys; a = json.load(open("labels.json"))["row_accuracy"]; assert a >= float(sys.argv[1]), a' "$1"
  }
  front=pair/true-masks/front
  accuracy 0.99
  refute grep doubt log
  cp $front/ball/body.png ball.png
  mask() { # VALUE: the front's mask of the ball, all pixels
    python3 - $front/ball/body.png "$1" <<'PY'
import struct, sys, zlib
path, value = sys.argv[1], int(sys.argv[2])
header = open(path, "rb").read()[16:24]
width, height = struct.unpack(">II", header)
chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
rows = zlib.compress((b"\0" + bytes([value]) * width) * height)
body = chunk(b"IHDR", header + bytes([8, 0, 0, 0, 0])) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
open(path, "wb").write(b"\x89PNG\r\n\x1a\n" + body)
PY
  }
  # Three views are left, and neighbours.
  mask 0
  accuracy 0.99
  mask 255
  accuracy 0.9
  grep -q "the mask of ball/body in front: it covers the whole image" log
  cp $front/box/body.png $front/ball/body.png
  accuracy 0.8
  grep -q "the masks of ball and box in front: they cover the same pixels" log
  # Nothing in any view: all of it becomes the other object's, and the tool says what no view shows.
  cp ball.png $front/ball/body.png
  rm -r pair/true-masks/*/ball
  accuracy 0.4
  grep -q "masks of ball/body: no view shows it" log
}
