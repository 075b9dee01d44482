#!/usr/bin/env bats
# A run of which a stage fails leaves a page that says which, what it said and what to do; make ends as it would without.
bats_require_minimum_version 1.5.0
load common
load coarse

setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  make_coarse_scene
}
setup() { cd "$BATS_FILE_TMPDIR" || return 1; }
ask() { run_make "$@" GAUSSIANS=bundle/gaussians.ply UP=z SPEC=spec.json RUN=run; }

@test "failed run: before there is a scene to show" {
  run ask run PROMPT='it <script>alert(1)</script> falls' SET='grid.n=<script>'
  echo "$output"
  [ "$status" -eq 2 ]
  [[ "$output" == *"pm-scene: error: "* ]]
  [[ "$output" == *"run/report.html says what failed and what to do"* ]]
  grep -q 'The stage “spec” failed</b> (pm-scene), exit code [23]' run/report.html
  grep -q '"stage": "spec"' run/report.json
  grep -q '&lt;script&gt;' run/report.html
  refute grep -q '<script>' run/report.html
  grep -qF 'RUN=run</pre>' run/report.html
}

@test "failed run: in the middle, with what there is; a run that goes on has its own page again" {
  ask run PROMPT='someone pushes it to the left' >out 2>&1
  grep -q accepted run/report.html
  for stage in bundle spec ground lift material candidates0 screen0; do [ -s "run/.stamps/$stage.time" ]; done
  grep -q '>candidates0</text>' run/report.html
  grep -q '>simulate posterior</text>' run/report.html
  python3 -c "
import json
plan = json.load(open('run/plan.json'))
plan['actions'][0]['target'] = 'no/such'
json.dump(plan, open('mine.json', 'w'))"
  run ask run PROMPT='someone pushes it to the left' PLAN=mine.json
  echo "$output"
  [ "$status" -eq 2 ]
  grep -q 'The stage “ground” failed</b> (pm-ground), exit code 3' run/report.html
  grep -q 'found &quot;no/such&quot;, expected an object id or a row key of the inventory' run/report.html
  grep -q '"message": "mine.json: /actions/0/target' run/report.json
  ask run PROMPT='someone pushes it to the left' >out 2>&1
  refute grep -q 'failed</b>' run/report.html
  grep -q '"failed": null' run/report.json
  [ ! -e run/.stamps/ground.failed ]
  [ "$(ask run PROMPT='someone pushes it to the left' 2>&1 | head -1)" = 'Nothing to do: run is up to date.' ]
}

@test "failed run: a command that was killed has said nothing, and an unreadable run is told with its request" {
  cp -r run killed
  rm -f killed/.stamps/*.failed
  "$bin/pm-report" --run killed --failed lift --status 137 --viewer 0
  grep -q 'The stage “lift” failed</b>, exit code 137' killed/report.html
  grep -q 'where memory runs out' killed/report.html
  echo broken >killed/plan.json
  "$bin/pm-report" --run killed --failed lift --status 137
  grep -q 'The stage “lift” failed' killed/report.html
  fails_with 3 "$bin/pm-report" --run killed -- plan.json
  fails_with 2 "$bin/pm-report" --run killed --failed lift --status 300 -- --status
}
