# The DAG of a run, as a user calls it: what reruns, what does not, and what a killed stage leaves.
load common

setup_file() {
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out "$BATS_FILE_TMPDIR/bundle"
  cd "$BATS_FILE_TMPDIR"
  run_make >first.log
}

setup() {
  cd "$BATS_TEST_TMPDIR"
  cp -a "$BATS_FILE_TMPDIR/bundle" "$BATS_FILE_TMPDIR/run" .
}

# make run on the bundle of the current folder, away from the make that runs the tests. Without the picture's defaults, so that
# a candidate's stages hang on it alone.
run_make() {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" --no-print-directory SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" \
    run SCENE="$PWD/bundle/scene.json" RUN="$PWD/run" DEFAULTS= "$@"
}

# The stages that a call ran, one line each: "simulate soft".
stages() { sed -nE "/^Accepted|^Nothing/q; s#^  ([a-z]+) +$PWD/run/(.*/)?([a-z0-9-]+)\..*#\1 \3#p; s#^  spec .*#spec#p"; }

@test "pipeline: a run ends accepted, with a video and its audit trail" {
  grep -q '^Accepted' "$BATS_FILE_TMPDIR/first.log"
  [ -s run/final.mp4 ]
  for record in accepted.json inventory.json plan.json evidence.json screen/round0.json; do [ -s "run/$record" ]; done
  grep -q '"decision": "accept"' run/screen/round0.json
  [ ! -e run/candidates/round1.json ]
}

@test "pipeline: a second run does nothing and says so" {
  before=$(fingerprint run)
  run run_make
  [ "$status" -eq 0 ]
  [[ "${lines[0]}" = "Nothing to do"* ]]
  [ "$(fingerprint run)" = "$before" ]
}

@test "pipeline: a new tau screens again and does nothing else" {
  run_make SET=screening.tau=0.5 >log
  stages <log
  [ "$(stages <log | sort -u | tr '\n' ' ')" = "report report screen round0 spec " ]
  grep -q '"tau": 0.5' run/screen/round0.json
}

@test "pipeline: a changed candidate is simulated, rendered and screened again, and no other" {
  sed -i -E '0,/"rho": [0-9.]+/s//"rho": 1234/' run/candidates/support-stiff.json
  run_make >log
  cat log; stages <log
  [ "$(stages <log | tr '\n' ' ')" = "simulate support-stiff render support-stiff screen round0 report report " ]
}

@test "pipeline: the picture: DEFAULTS and CAMERA rerun videos, and change no verdict" {
  verdict() { python3 -c "import json; print([(c['id'], c['score'], c['gates']) for c in json.load(open('run/screen/round0.json'))['candidates']])"; }
  before=$(verdict)
  run_make DEFAULTS="render.camera=fit render.floor=shadow" >log
  stages <log
  refute grep -E 'ground|lift|material|candidates|simulate' <(stages <log)
  [ "$(stages <log | grep -c '^render')" -eq "$(ls run/rollouts/*.h5 | wc -l)" ]
  stages <log | grep -q 'camera round0'
  grep -q '"shadow"' run/spec/render.json
  [ "$(verdict)" = "$before" ]
  run_make DEFAULTS="render.camera=fit render.floor=shadow" >log
  grep -q '^Nothing to do' log
  run_make CAMERA=orbit >log
  grep -q '"mode": "orbit"' run/cameras/round0.json
  [ "$(verdict)" = "$before" ]
  run_make CAMERA=fixed >log
  refute grep -q camera <(stages <log)
  [ "$(verdict)" = "$before" ]
  run run_make CAMERA=near
  [ "$status" -ne 0 ]
  [[ "$output" = *"/render/camera"* ]]
}

@test "pipeline: a setting of the solver reruns from the simulation on" {
  run_make SET=gravity=-5 >log
  refute grep -E 'ground|lift|material|candidates' <(stages <log)
  stages <log | grep -q 'simulate support-stiff'
}

@test "pipeline: a missing artifact is made again" {
  rm run/evidence.json run/rollouts/support-stiff.h5
  run_make >log
  stages <log | grep -q 'material evidence'
  stages <log | grep -q 'simulate support-stiff'
  refute grep lift <(stages <log)
}

@test "pipeline: candidates in parallel give the same bytes" {
  rm -rf run
  run_make -j2 >log
  for file in candidates/support-stiff.json rollouts/support-stiff.h5 videos/support-stiff.mp4 screen/round0.json final.mp4; do
    # The screen's provenance holds hashes of records with run times; what it decides must be equal.
    if [ "$file" = screen/round0.json ]; then
      diff <(sed '/"sha256"/d' run/$file) <(sed '/"sha256"/d' "$BATS_FILE_TMPDIR/run/$file")
    else
      cmp "run/$file" "$BATS_FILE_TMPDIR/run/$file"
    fi
  done
}

@test "pipeline: a killed simulation leaves nothing that a rerun trusts" {
  # Minutes of work, so that the first simulation runs until it is killed: once the file that it writes is there, whose name
  # holds its process id.
  run_make SET="time.frames=4000 time.rule=cfl" >log 2>&1 3>&- &
  started=$!
  until half=$(compgen -G 'run/rollouts/.*.h5.*.tmp') || ! kill -0 "$started"; do sleep 0.02; done
  [[ "$half" =~ ^run/rollouts/\.(.*)\.h5\.([0-9]+)\.[0-9]+\.[0-9a-f]+\.tmp$ ]] || { cat log; kill "$started"; return 1; }
  candidate=${BASH_REMATCH[1]}
  kill -KILL "${BASH_REMATCH[2]}"
  status=0
  wait "$started" || status=$?
  cat log
  [ "$status" -ne 0 ]
  # The stage counts as not done, and what it replaces is whole.
  [ run/spec/simulate.json -nt "run/.stamps/simulate-$candidate" ]
  for file in h5 json; do cmp "run/rollouts/$candidate.$file" "$BATS_FILE_TMPDIR/run/rollouts/$candidate.$file"; done
  run_make >log
  grep -q '^Accepted' log
  cmp run/final.mp4 "$BATS_FILE_TMPDIR/run/final.mp4"
}

@test "pipeline: an interruption leaves no temporary file" {
  # Minutes of work, but no more steps than are allowed.
  for signal in INT TERM; do
    # As the terminal does it: the signal goes to make and all that it started. A background job would ignore SIGINT.
    python3 -c 'import os, signal, sys
os.setsid()
signal.signal(signal.SIGINT, signal.SIG_DFL)
os.execvp(sys.argv[1], sys.argv[1:])' env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$bin" run \
      SCENE="$PWD/bundle/scene.json" RUN="$PWD/run" SET="time.frames=400 time.frame_dt=4 time.max_substeps=1000000" >log 2>&1 3>&- &
    started=$!
    until compgen -G 'run/rollouts/.*.h5.*.tmp' >half || ! kill -0 "$started"; do sleep 0.02; done
    kill -"$signal" -- -"$started"
    status=0
    wait "$started" || status=$?
    cat log half
    [ -s half ]
    [ "$status" -ne 0 ]
    [ -z "$(find . -name '.*.tmp*')" ]
  done
}

@test "pipeline: a scene that needs a repair round ends accepted after it" {
  # Of two candidates the better one lacks 0.015 to tau; role balancing makes its plasticine a jelly.
  run_make SET="screening.initial=2 screening.tau=1.0" DEFAULTS=render.camera=fit >log
  grep -q '^Accepted' log
  # The camera of the second round has seen both.
  [ "$(python3 -c "import json; print(json.load(open('run/cameras/round1.json'))['candidates'][-1])")" = hard-support-bonded-role-balanced ]
  grep -q '"hard-support-bonded"' run/cameras/round1.json
  grep -q '"decision": "repair"' run/screen/round0.json
  grep -q '"candidate": "hard-support-bonded-role-balanced"' run/accepted.json
  [ ! -e run/candidates/round2.json ]
}

@test "pipeline: of more Gaussians than particles some carry the others, and the video shows all" {
  run_make SET="particles.max=100 screening.initial=2" >log
  grep -q '^Accepted' log
  grep -aq '50 of [0-9]* Gaussians are particles and carry the others' run/state.h5
  # As much is seen at rest as when all are simulated, and only the carriers are in the rollout.
  area() { sed -nE 's/.*"area": ([0-9]+).*/\1/p' "$1" | head -n 1; }
  [ "$(area run/videos/hard-support-bonded.json)" -gt 100 ]
  [ "$(area run/videos/hard-support-bonded.json)" = "$(area "$BATS_FILE_TMPDIR/run/videos/hard-support-bonded.json")" ]
  [ "$(stat -c %s run/rollouts/hard-support-bonded.h5)" -lt "$(stat -c %s "$BATS_FILE_TMPDIR/run/rollouts/hard-support-bonded.h5")" ]
}

@test "pipeline: the studies without object-part state and without structure projection" {
  run_make SET=ablation.structure_projection=false >log
  refute grep -E 'ground|lift|material' <(stages <log)
  refute grep -E '"(structure_projection|interface_retention)"' run/candidates/*[a-z].json
  run_make SET=ablation.object_part_state=false >log
  [ "$(grep -c '"key": ".*/whole"' run/evidence.json)" -eq 1 ]
  refute grep '"key": "lollipop/stick"' run/evidence.json
}

@test "pipeline: other material records rerun the material stage and what depends on it" {
  cat >records.json <<'J'
{"schema": "physmas/material_records/1", "rows": [{"key": "lollipop/stick", "crops": [{"E": 2e9, "E_uncertainty": 0.1, "nu": 0.3}]}]}
J
  run_make PREDICTOR="$PWD/records.json" >log
  refute grep -E 'ground|lift' <(stages <log)
  stages <log | grep -q 'material evidence'
  grep -q '"E": 2000000000.0' run/evidence.json
  run_make PREDICTOR="$PWD/records.json" >log
  grep -q '^Nothing to do' log
}

@test "pipeline: what cannot be admitted is repaired, and in the end refused with a table of why" {
  run run_make SET=screening.tau=9
  [ "$status" -ne 0 ]
  [[ "$output" = *"Error 6"* ]]
  [[ "$output" = *"rank  candidate"* ]]
  [ ! -e run/final.mp4 ]
  [ ! -e run/accepted.json ]
  grep -q '"decision": "fail"' run/screen/round*.json
}

@test "pipeline: an imported file; a new prompt reruns what depends on it, not the views" {
  cp bundle/gaussians.ply scene.ply
  import() {
    env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" --no-print-directory SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" run \
      GAUSSIANS="$PWD/scene.ply" UP=z RUN="$PWD/run" SPEC="$PWD/spec.json" "$@"
  }
  cat >spec.json <<'J'
{"schema": "physmas/run/1", "grid": {"n": 24}, "time": {"frames": 10, "substep_dt": 8e-4, "min_substep_dt": 2e-4, "max_substeps": 200}, "render": {"width": 320, "height": 320}}
J
  rm -rf run
  import PROMPT="the thing's \"\$5\" falls" >log
  grep -q '^Accepted' log
  grep -qF "the thing's \\\"\$5\\\" falls" run/plan.json
  before=$(stat -c %y run/bundle/views/front.png)
  import PROMPT="the thing drops onto the floor" >log
  stages <log | grep -q 'ground'
  [ "$(stat -c %y run/bundle/views/front.png)" = "$before" ]
  import PROMPT="the thing drops onto the floor" >log
  grep -q "^Nothing to do" log
}

@test "pipeline: mistakes on make's command line are explained" {
  run env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" run
  [ "$status" -ne 0 ]
  [[ "$output" = *"GAUSSIANS=file.ply"* ]]
  run env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" run GAUSSIANS=x.ply
  [ "$status" -ne 0 ]
  [[ "$output" = *"PROMPT"* ]]
  run env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" run GAUSSIANS=missing.ply PROMPT=x RUN="$PWD/run2"
  [ "$status" -ne 0 ]
  [[ "$output" = *"missing.ply"* ]]
}

@test "pipeline: ERROR=1 estimates the accepted run's error, once" {
  run_make_here() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$bin" "$@"; }
  cd "$BATS_TEST_TMPDIR"
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle --quiet
  set -- run SCENE=bundle/scene.json RUN=run SET="grid.n=32 time.frames=4 screening.initial=2 screening.rounds=1 screening.tau=-9 render.width=64 render.height=64"
  run run_make_here "$@" ERROR=yes
  [ "$status" -eq 2 ]
  [[ "$output" = *"ERROR"*"expected 1"* ]]
  run_make_here "$@" >/dev/null
  [ ! -e run/error.json ]
  run_make_here "$@" ERROR=1 >log
  grep -q '^position ' log
  grep -q 'run/error.json' log
  candidate() { grep -o '"candidate": "[a-z-]*"' "$1"; }
  [ "$(candidate run/error.json)" = "$(candidate run/accepted.json)" ]
  run_make_here "$@" ERROR=1 >log
  grep -q '^Nothing to do' log
  # A run that has changed is estimated again.
  run_make_here "${@/time.frames=4/time.frames=5}" ERROR=1 >log
  grep -q '^position ' log
  rm run/error.json
  run_make_here "${@/time.frames=4/time.frames=5}" ERROR=1 >log
  [ -s run/error.json ]
  "$bin/pm-screen" --audit run
  # The page shows it, and no longer where it is another rollout's.
  grep -q 'How far the grid may be from the truth' run/report.html
  sed -i 's/"candidate": "/"candidate": "x-/' run/error.json
  "$bin/pm-report" --run run --out other.html
  refute grep 'How far the grid may be' other.html
}
