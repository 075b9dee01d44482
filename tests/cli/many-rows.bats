#!/usr/bin/env bats
# As many parts as a scene may have, and more.
load common
load coarse

# many OBJECTS PARTS: an example of that many objects with that many balls each.
many() {
  python3 - "$root/tests/data/tiny.json" "$1" "$2" <<'PY'
import json, sys
example = json.load(open(sys.argv[1]))
objects, parts = int(sys.argv[2]), int(sys.argv[3])
example.update(name="many", prompt="everything falls onto the floor", spacing=0.1)
example["objects"] = [
    {"id": "o%d" % i, "name": "thing %d" % i, "scene_role": "target",
     "parts": [{"part": "p%d" % k, "name": "part %d" % k, "structural_role": "body", "physics_group": "g%d" % k, "expected_labels": ["Rubber"],
                "shapes": [{"type": "sphere", "radius": 0.2, "center": [i % 3 * 1.5, i // 3 * 1.5, 0.3 + 0.4 * k], "color": [k * 37 % 100 / 100, i * 17 % 100 / 100, 0.5]}]}
               for k in range(parts)]} for i in range(objects)]
json.dump(example, open("many.json", "w"))
PY
}

@test "many rows: 200 parts of eight objects go through every stage" {
  cd "$BATS_TEST_TMPDIR"
  many 8 25
  "$bin/pm-scene" synth many.json --out bundle --quiet
  run_make run SCENE=bundle/scene.json RUN=run \
    SET="grid.n=32 time.frames=2 screening.initial=1 screening.rounds=1 screening.tau=-9 render.width=48 render.height=48 time.substep_dt=4e-4 time.min_substep_dt=2e-4 time.max_substeps=100" >log 2>&1 ||
    { cat log; return 1; }
  [ "$(grep -c '"key":' run/candidates/posterior.json)" -ge 200 ]
  "$bin/pm-screen" --audit run
}

@test "many rows: more objects than the schema allows are refused" {
  cd "$BATS_TEST_TMPDIR"
  many 65 1
  fails_with 3 "$bin/pm-scene" synth many.json --out bundle -- /objects 64
  [ ! -e bundle ]
}
