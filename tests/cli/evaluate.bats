#!/usr/bin/env bats
# make evaluate: a registered benchmark of two small cases, one of which fails.
load common

setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  mkdir -p suite/references
  cp "$root/tests/data/tiny.json" suite/good.json
  # Nobody knows what that is: the scene agent refuses it.
  sed 's/the lollipop falls onto the floor/a hand presses down on the elephant/' suite/good.json >suite/bad.json
  for name in good bad; do
    cat >suite/references/$name.json <<'JSON'
{"schema": "physmas/configuration/1", "note": "marker-of-the-reference",
 "settings": ["grid.n=28"],
 "rows": {"lollipop/candy": {"branch": "Jelly", "E": 123456.789, "nu": 0.4, "rho": 1100},
          "lollipop/stick": {"branch": "Metal", "E": 1e6, "nu": 0.3, "rho": 700}},
 "actions": []}
JSON
  done
  cat >suite/suite.json <<'JSON'
{"schema": "physmas/suite/1", "settings": ["render.width=160", "render.height=160"],
 "methods": [{"id": "full", "name": "Full", "settings": []},
             {"id": "single", "name": "Single", "settings": ["ablation.part_materials=false", "screening.initial=1",
                                                            "screening.rounds=1"], "candidate": "posterior"}],
 "comparison": ["single", "full"], "required": ["trajectory_nrmse", "area_log_rmse", "strain_rmse", "seconds"],
 "cases": [
  {"id": "bad", "kind": "multi-part", "example": "bad.json", "reference": "references/bad.json", "objects": ["lollipop"]},
  {"id": "good", "kind": "multi-part", "example": "good.json", "reference": "references/good.json", "objects": ["lollipop"]}]}
JSON
  "$bin/pm-eval" suite --suite suite/suite.json --register
  evaluate -j2 >first.log 2>&1 || { cat first.log; return 1; }
}

evaluate() {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" --no-print-directory SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" \
    evaluate SUITE="$BATS_FILE_TMPDIR/suite/suite.json" EVALUATE="$BATS_FILE_TMPDIR/out" "$@"
}
setup() { cd "$BATS_FILE_TMPDIR" || return 1; }

# Cell of tables/cases.csv: CASE METHOD COLUMN.
cell() {
  python3 - "$@" <<'PY'
import csv, sys
rows = list(csv.reader(open("out/tables/cases.csv")))
print([r[rows[0].index(sys.argv[3])] for r in rows if r[0] == sys.argv[1] and sys.argv[2] in r][0])
PY
}

@test "evaluate: a case that fails is in the tables as a failure and stops no other" {
  cat first.log
  [ "$(tail -n +2 out/tables/cases.csv | wc -l)" -eq 4 ]
  for method in full single; do
    [ "$(cell good $method Status)" = done ]
    [ "$(cell bad $method Status)" = failed ]
    [[ "$(cell bad $method Why)" = *elephant* ]]
    [ -n "$(cell good $method trajectory_nrmse)" ]
    [ -z "$(cell bad $method trajectory_nrmse)" ]
    [ -s out/results/good/$method/motion-lollipop.json ]
  done
  # The failure counts: nothing is averaged over the rest.
  grep -q invalid out/tables/trajectory.md
  # One material per object: both rows have it.
  python3 -c 'import json; a, b = [r for r in json.load(open("out/good/single/candidates/posterior.json"))["rows"] if not r["residual"]]
assert (a["branch"], a["E"], a["nu"], a["rho"]) == (b["branch"], b["E"], b["nu"], b["rho"])'
  # References are simulated in double precision on the grid that they name, with the true rows.
  grep -q '"precision": "double"' out/references/good-*/rollout.json
  grep -q '"n": 28' out/references/good-*/rollout.json
}

@test "evaluate: what the methods share is computed once" {
  cmp out/good/full/state.h5 out/good/single/state.h5
  cmp out/good/full/evidence.json out/good/single/evidence.json
}

@test "evaluate: a second call computes nothing" {
  before=$(fingerprint out)
  evaluate >second.log
  refute grep -E "synth|reference  |simulate|done  |failed  " second.log
  [ "$(fingerprint out)" = "$before" ]
}

@test "evaluate: some of the cases" {
  evaluate CASES=good EVALUATE="$BATS_FILE_TMPDIR/out" >some.log
  [ "$(tail -n +2 out/tables/cases.csv | wc -l)" -eq 2 ]
  run evaluate CASES=cow
  [ "$status" -ne 0 ]
  [[ $output = *"--cases"*cow*"bad good"* ]]
}

@test "evaluate: nothing of a reference reaches a method's inputs or artifacts" {
  reference=$(sha256sum suite/references/good.json | cut -d' ' -f1)
  # The marker is where it belongs, so that the search would find it.
  grep -rq 123456.789 out/references
  grep -q marker-of-the-reference suite/references/good.json
  refute grep -rlE "marker-of-the-reference|123456.789|$reference|/references/" out/good out/bad out/bundle
  # The true rows are not in the bundle that methods get.
  [ -z "$(find out/bundle out/good -name 'truth*')" ]
}

@test "evaluate: a file that changed since it was registered is refused by name" {
  cp -r suite changed
  sed -i 's/1e6/2e6/' changed/references/good.json
  run evaluate SUITE="$BATS_FILE_TMPDIR/changed/suite.json" EVALUATE="$BATS_FILE_TMPDIR/refused"
  [ "$status" -ne 0 ]
  [[ $output = *changed/references/good.json*"make evaluate-register"* ]]
  [ ! -e refused/good ]
  [ ! -e refused/bundle ]
  fails_with 3 "$bin/pm-eval" suite --suite changed/suite.json -- changed/references/good.json SHA-256 evaluate-register
  "$bin/pm-eval" suite --suite changed/suite.json --register
  "$bin/pm-eval" suite --suite changed/suite.json
  # It is what sha256sum writes.
  (cd changed; sha256sum -c --quiet suite.sha256)
  sed -i '/good.json$/d' changed/suite.sha256
  fails_with 3 "$bin/pm-eval" suite --suite changed/suite.json -- good.json "no hash"
}

@test "evaluate: a suite that does not fit its files" {
  cp -r suite misfit
  sed -i 's/"objects": \["lollipop"\]}\]/"objects": ["cow"]}]/' misfit/suite.json
  fails_with 3 "$bin/pm-eval" suite --suite misfit/suite.json --register -- /cases/1/objects cow
  cp suite/suite.json misfit/
  sed -i 's|lollipop/stick|lollipop/stock|' misfit/references/good.json
  fails_with 3 "$bin/pm-eval" suite --suite misfit/suite.json --register -- references/good.json lollipop/stick
  sed -i 's|"good.json"|"../good.json"|' misfit/suite.json
  fails_with 3 "$bin/pm-eval" suite --suite misfit/suite.json --register -- /example ../good.json
}
