#!/usr/bin/env bats
# pm-eval labels: the toy's labels against the truth in its bundle.
bats_require_minimum_version 1.5.0
load toy
load common

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
