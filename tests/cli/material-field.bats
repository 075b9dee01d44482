#!/usr/bin/env bats
# MATERIALS=: elastic numbers and densities that another program found at points of the scene, from its file to the solver.

bats_require_minimum_version 1.5.0

load common
load coarse

setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  make_coarse_scene
  # The lollipop in two rows of one label, and the same in one.
  python3 - "$root/tests/data/tiny.json" <<'P'
import json, sys
example = json.load(open(sys.argv[1]))
candy, stick = example["objects"][0]["parts"]
stick["expected_labels"] = candy["expected_labels"]
# Shapes of one part have no surface where they touch.
stick["shapes"][0].update(height=0.6, center=[0, 0, 0.3])
json.dump(example, open("two.json", "w"))
candy["shapes"] += stick["shapes"]
example["objects"][0]["parts"] = [candy]
# Also what is filled far inside takes the nearest sample, as it takes the row of the nearest Gaussian.
example["run"]["lifting"] = {"field_reach": 20}
json.dump(example, open("one.json", "w"))
P
  for rows in one two; do "$bin/pm-scene" synth $rows.json --out $rows --quiet; done
  # As many Gaussians: they are made to be the same ones.
  cmp <(head -n 3 one/gaussians.ply) <(head -n 3 two/gaussians.ply)
  cp two/gaussians.ply one/gaussians.ply
  for how in halves constant moved; do write one/gaussians.ply $how.npz $how; done
  write one/gaussians.ply halves.usda
}

setup() {
  cd "$BATS_TEST_TMPDIR" || return 1
  FILES=$BATS_FILE_TMPDIR
}

write() { # PLY FILE [HOW]
  python3 "$root/tests/cli/material_fields.py" write "$@"
}

import() { # FIELD ARGUMENTS...
  local field=$1
  shift
  "$bin/pm-scene" import "$FILES/one/gaussians.ply" --up z --prompt "it falls" --run "$FILES/spec.json" --materials "$field" --out "${OUT:-bundle}" "$@"
}

# field_of FILE ROW: its field in an evidence record.
field_of() {
  python3 -c 'import json, sys
print(json.dumps(json.load(open(sys.argv[1]))["rows"][int(sys.argv[2])].get("field")))' "$@"
}

# evidence_of FIELD FOLDER: what the field in this file says of the row, in a run without candidates.
evidence_of() {
  OUT=$2 import "$1" --quiet
  "$bin/pm-ground" --scene "$2/scene.json" --material Rubber --out "$2" --quiet
  "$bin/pm-lift" --scene "$2/scene.json" --inventory "$2/inventory.json" --masks "$2/masks.h5" --out "$2/state.h5" --quiet
  "$bin/pm-material" --scene "$2/scene.json" --inventory "$2/inventory.json" --masks "$2/masks.h5" --state "$2/state.h5" \
    --out "$2/evidence.json" --quiet
  field_of "$2/evidence.json" 0
}

@test "field: two constant halves move as two rows do" {
  cp -r "$FILES/one" "$FILES/two" .
  import "$FILES/halves.npz" --quiet
  cp bundle/material-field.h5 one
  sed -i '0,/"run": {/s//"material_field": "material-field.h5", "run": {/' one/scene.json
  grep -q material_field one/scene.json
  for rows in one two; do
    "$bin/pm-ground" --scene $rows/scene.json --out $rows/run --quiet
    "$bin/pm-lift" --scene $rows/scene.json --inventory $rows/run/inventory.json --labels $rows/truth.h5 --out $rows/run/state.h5
  done
  "$bin/pm-material" --scene one/scene.json --inventory one/run/inventory.json --masks one/run/masks.h5 --state one/run/state.h5 --out one/run/evidence.json
  "$bin/pm-candidates" --scene one/scene.json --inventory one/run/inventory.json --plan one/run/plan.json --evidence one/run/evidence.json \
    --state one/run/state.h5 --out one/run/candidates
  cp one/run/candidates/posterior.json one/run/it.json
  cat >two.json <<'J'
{"schema": "physmas/configuration/1", "actions": [], "rows": {
 "lollipop/candy": {"branch": "Jelly", "E": 2e5, "nu": 0.42, "rho": 1100}, "lollipop/stick": {"branch": "Jelly", "E": 4e4, "nu": 0.42, "rho": 600}}}
J
  "$bin/pm-candidates" --scene two/scene.json --inventory two/run/inventory.json --configuration two.json --state two/run/state.h5 --out two/run/candidates
  cp two/run/candidates/authored.json two/run/it.json
  for rows in one two; do
    "$bin/pm-simulate" --scene $rows/scene.json --state $rows/run/state.h5 --candidate $rows/run/it.json --out $rows.h5 --timestep 4e-4 --precision double
    "$bin/pm-render" --scene $rows/scene.json --state $rows/run/state.h5 --rollout $rows.h5 --out $rows.mp4 --npz $rows.npz
  done
  python3 "$root/tests/cli/material_fields.py" same one.npz two.npz 2e-6
  # Which the field did: the row alone moves otherwise.
  sed -i '/"field": {/,/}/d; s/"residual": false,$/"residual": false/' one/run/it.json
  "$bin/pm-simulate" --scene one/scene.json --state one/run/state.h5 --candidate one/run/it.json --out row.h5 --timestep 4e-4 --precision double
  "$bin/pm-render" --scene one/scene.json --state one/run/state.h5 --rollout row.h5 --out row.mp4 --npz row.npz
  python3 "$root/tests/cli/material_fields.py" differ row.npz two.npz 1e-3
}

@test "field: npz and USD text say the same" {
  evidence_of "$FILES/halves.npz" npz >a
  evidence_of "$FILES/halves.usda" usda >b
  grep -q '"least": 40000.0, .*"most": 200000.0' a
  cmp a b
  grep -q '"material_field": "material-field.h5"' npz/scene.json
  grep -q 'halves.npz' npz/scene.json
}

@test "field: what other people's USD writes is read, and their crate is refused with what to do" {
  python=${PM_PYTHON:-$root/build/test/python/bin/python}
  "$python" -c "import pxr" 2>/dev/null || skip "$python lacks pxr: make test-python installs it"
  "$python" - "$FILES/one/gaussians.ply" "$root/tests/cli" <<'P'
import sys
sys.path.insert(0, sys.argv[2])
import exported, material_fields
from pxr import Sdf, Usd, UsdGeom
arrays = material_fields.field([(r["x"], r["y"], r["z"]) for r in exported.read_ply(sys.argv[1])], "halves")
for name in ("theirs.usda", "theirs.usdc"):
    stage = Usd.Stage.CreateNew(name)
    UsdGeom.Xform.Define(stage, "/World")
    points = UsdGeom.Points.Define(stage, "/World/voxels")
    flat = arrays["positions"][0]
    points.CreatePointsAttr([tuple(flat[i:i + 3]) for i in range(0, len(flat), 3)])
    variables = UsdGeom.PrimvarsAPI(points)
    for array, usd in zip(material_fields.ORDER[1:], ("yms", "prs", "rhos")):
        variables.CreatePrimvar(usd, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex).Set(arrays[array][0])
    stage.SetDefaultPrim(stage.GetPrimAtPath("/World"))
    stage.Save()
P
  evidence_of theirs.usda theirs >a
  evidence_of "$FILES/halves.npz" ours >b
  cmp a b
  fails_with 3 import theirs.usdc -- "a binary USD crate" "usdcat --flatten"
  [ ! -e bundle ]
}

@test "field: bad files are refused by name, and nothing is left" {
  while IFS='|' read -r how said; do
    write "$FILES/one/gaussians.ply" bad.npz "$how"
    fails_with 3 import bad.npz -- bad.npz "$said"
    [ ! -e bundle ]
  done <<'L'
missing|density.npy: found no such entry
shape|poisson_ratio: found shape
nan|Young's modulus of nan Pa in sample 3
negative|density of -1 kg/m^3 in sample 3
nu|Poisson's ratio of 0.69
nowhere|expected three finite coordinates
huge|the header of an array
moved|where the Gaussians are
L
  cp "$FILES/halves.npz" cut.npz
  truncate -s -20 cut.npz
  fails_with 3 import cut.npz -- cut.npz "a whole ZIP archive"
  echo '{}' >field.json
  fails_with 3 import field.json -- "a material field: .npz, or .usda as text"
  fails_with 3 import none.npz -- "No such file"
  # A bundle's field stays in the bundle.
  import "$FILES/halves.npz" --quiet
  cp bundle/material-field.h5 .
  sed -i 's#"material-field.h5"#"../material-field.h5"#' bundle/scene.json
  fails_with 3 "$bin/pm-lift" --scene bundle/scene.json --inventory x.json --masks x.h5 --out s.h5 -- "/material_field"
}

@test "field: make takes it, records what it did, passes the audit, and reruns what depends on it alone" {
  it() { run_make run GAUSSIANS="$FILES/one/gaussians.ply" UP=z PROMPT="it falls" MATERIAL=Rubber SPEC="$FILES/spec.json" RUN=run MATERIALS=field.npz "$@"; }
  cp "$FILES/halves.npz" field.npz
  it >log 2>&1
  grep -q '^Accepted' log
  grep -q 'the material field has .* % of its particles, E 4e+04 to 2e+05 Pa' log
  run field_of run/evidence.json 0
  [[ $output == *'"clamped": 0'* ]]
  grep -q '"field": {' run/candidates/posterior.json
  grep -q 'material-field.h5' run/spec/lift.json
  refute grep -q 'material-field.h5' run/spec/material.json
  run_make audit RUN=run >audit 2>&1
  grep -qE 'material field: [0-9]+ % of the particles, E 40 kPa to 200 kPa' run/report.html
  # Again: nothing. Another file: what comes after the bundle, with the same Gaussians.
  it >again 2>&1
  refute grep -qE '^  (import|ground|lift|material|candidates|simulate) ' again
  write "$FILES/one/gaussians.ply" field.npz constant
  it >other 2>&1
  for stage in import lift material simulate; do grep -q "^  $stage " other; done
  refute grep -qE '^  ground ' other
  grep -q 'E 4e+04 to 4e+04 Pa' other
  # What was changed behind the records is found.
  cp "$FILES/one/gaussians.ply" run/bundle/material-field.h5
  run run_make audit RUN=run
  [ "$status" -ne 0 ]
  [[ $output == *material-field.h5* ]]
}

@test "field: a scene without one has nothing of it" {
  run_make run GAUSSIANS="$FILES/one/gaussians.ply" UP=z PROMPT="it falls" SPEC="$FILES/spec.json" RUN=plain >log 2>&1
  refute grep -rlE 'field_reach|material_field|"field"' plain/spec plain/bundle/scene.json plain/evidence.json plain/candidates
  refute grep -aqE 'youngs_modulus' plain/state.h5
}

@test "field: particles that are too far from every sample have their row's material, and that is said" {
  run_make run GAUSSIANS="$FILES/one/gaussians.ply" UP=z PROMPT="it falls" MATERIAL=Rubber SPEC="$FILES/spec.json" RUN=run MATERIALS="$FILES/halves.npz" \
    SET="lifting.field_reach=0.2" >log 2>&1
  grep -q 'warning: material field: .* particles have no sample within' log
  run field_of run/evidence.json 0
  python3 -c 'import json, sys
field = json.loads(sys.argv[1])
assert 0 < field["sampled"] < field["particles"], field' "$output"
}
