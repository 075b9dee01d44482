#!/usr/bin/env bats
# What is recorded is what is there: every stage checks the hashes of what it reads, pm-screen --audit checks a whole run, equal
# inputs give equal bytes, and what is gone is made again.
load common
load coarse
load server

same_runs() { python3 -B "$root/tests/tools/compare_runs.py" "$@"; }
# make_run FOLDER ARGUMENT...: from $BATS_FILE_TMPDIR, so that all have the same source.
make_run() (
  local folder=$1
  shift
  cd "$BATS_FILE_TMPDIR" || exit 1
  run_make run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" UP=z SPEC=spec.json RUN="$folder" "$@" 2>/dev/null
)

setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  make_coarse_scene
  make_run one
}

setup() {
  cd "$BATS_TEST_TMPDIR" || return 1
  cp -a "$BATS_FILE_TMPDIR/one" run
}

flip() { # FILE [OFFSET]: the lowest bit of a byte
  python3 -c 'import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[int(sys.argv[2]) if len(sys.argv) > 2 else len(data) // 2] ^= 1
open(sys.argv[1], "wb").write(data)' "$@"
}

# The files that the audit must know: all that a run makes, but requests, facts for make, and what is itself a root or has no record.
recorded() {
  find run -type f -not -path 'run/.stamps/*' -printf '%P\n' >files
  grep -vE '\.mk$|^(settings|changes|request|source|models|ground-models|(accepted|report).json)$|^inputs/|^bundle/scene.json$' files >chosen
  sort chosen
}

@test "audit: two clean runs are equal, but for run times" {
  # Beside each other: what lies near is named with its folder.
  make_run two >/dev/null
  mv "$BATS_FILE_TMPDIR/two" .
  run same_runs run two
  echo "$output"
  [ "$status" -eq 0 ]
  # The comparison sees a difference.
  sed -i 's/"score": /"score": 1/' two/accepted.json
  [ "$(same_runs run two)" = "different: accepted.json" ]
}

@test "audit: a finished run is what was recorded" {
  "$bin/pm-screen" --audit run >text
  cat text
  grep -qE '^run: [0-9]+ files are what was recorded, 0 are not; ' text
  [ "$(wc -l <text)" -eq 1 ]
  grep -q "$(sha256sum <run/accepted.json | cut -c -64)" text
  run_make audit RUN=run
  # Moved, and with other run times, it is the same run.
  mv run moved
  sed -i -E 's/("peak_memory_bytes": )[0-9]+/\17/' moved/videos/*.json moved/rollouts/*.json
  "$bin/pm-screen" --audit moved >/dev/null
  mkdir empty
  fails_with 3 "$bin/pm-screen" --audit empty -- "no screen/roundN.json"
}

@test "audit: every file that is changed or gone is named" {
  [ "$(recorded | wc -l)" -gt 25 ]
  for file in $(recorded); do
    cp "run/$file" kept
    case $file in
      # A bit of the run times means nothing.
      rollouts/*.json | videos/*.json) sed -i 's/"candidate": "/"candidate": "x/' "run/$file" ;;
      *) flip "run/$file" ;;
    esac
    status=0
    "$bin/pm-screen" --audit run >text 2>error || status=$?
    [ "$status" -eq 3 ] && grep -qF "$file: is not what " text && [ "$(wc -l <error)" -eq 1 ] || { cat text error; echo "$file: a change is not found"; return 1; }
    rm "run/$file"
    status=0
    "$bin/pm-screen" --audit run >text 2>error || status=$?
    [ "$status" -eq 3 ] && grep -qF "$file: is not there; " text || { cat text error; echo "$file: not missed"; return 1; }
    cp kept "run/$file"
  done
  "$bin/pm-screen" --audit run >/dev/null
  # accepted.json is named by nothing: what it says is held against the screen.
  sed -i 's/"candidate": "[a-z-]*"/"candidate": "posterior"/; s/"score": [^,]*/"score": 7/' run/accepted.json
  run "$bin/pm-screen" --audit run
  [ "$status" -eq 3 ]
  [[ $output = *"accepted.json: gives the score 7"* ]]
}

render() { "$bin/pm-render" --scene run/spec/render.json --state run/state.h5 --rollout run/rollouts/soft.h5 --out video/soft.mp4 "$@"; }
screen() {
  "$bin/pm-screen" --scene run/spec/screen.json --plan run/plan.json --evidence run/evidence.json --inventory run/inventory.json \
    --candidates run/candidates --rollouts run/rollouts --videos run/videos --round 0 --out out/round0.json --accepted out/accepted.json --final out/final.mp4 "$@"
}

@test "hashes: a rollout with a flipped bit is not rendered" {
  render
  size=$(stat -c %s run/rollouts/soft.h5)
  cp run/rollouts/soft.h5 kept
  for i in $(seq 40); do
    cp kept run/rollouts/soft.h5
    flip run/rollouts/soft.h5 $((i * (size - 1) / 40))
    fails_with 3 render -- run/rollouts/soft.json /provenance/outputs/0 SHA-256 || { echo "bit $i"; return 1; }
  done
}

@test "hashes: another candidate's video, a deleted rollout and a rollout of another candidate are not screened" {
  screen
  [ -s out/final.mp4 ]
  rm -r out
  cp -a run clean
  again() { rm -rf run; cp -a clean run; }
  cp run/videos/posterior.mp4 run/videos/soft.mp4
  fails_with 3 screen -- run/videos/soft.json "soft.mp4 with SHA-256"
  again
  rm run/rollouts/soft.h5
  fails_with 3 screen -- run/rollouts/soft.h5
  again
  cp run/rollouts/posterior.h5 run/rollouts/soft.h5
  fails_with 3 screen -- run/rollouts/soft.json "soft.h5 with SHA-256"
  again
  sed -i 's/"confidence": 0/"confidence": 0.0/' run/evidence.json
  sed -i 's/"rounds"/ "rounds"/; s/^{$/{ /' run/evidence.json
  fails_with 3 screen -- "made from a evidence.json"
  [ ! -e out ]
}

@test "hashes: a state, masks and an inventory of another scene are not taken" {
  sed 's/"center": \[0, 0, 1.2\]/"center": [0, 0, 1.21]/' "$root/tests/data/tiny.json" >other.json
  "$bin/pm-scene" synth other.json --out bundle --quiet
  "$bin/pm-ground" --scene bundle/scene.json --out other 2>/dev/null
  "$bin/pm-lift" --scene bundle/scene.json --inventory other/inventory.json --masks other/masks.h5 --out other/state.h5 2>/dev/null
  refute cmp -s other/state.h5 run/state.h5
  fails_with 3 render --state other/state.h5 -- "made from a state.h5"
  fails_with 3 "$bin/pm-simulate" --scene run/spec/simulate.json --state other/state.h5 --candidate run/candidates/soft.json --out x.h5 -- "made from a state.h5"
  fails_with 3 "$bin/pm-render" fit --scene run/spec/render.json --state other/state.h5 --rollout run/rollouts/soft.h5 --out x.json -- "made from a state.h5"
  fails_with 3 "$bin/pm-lift" --scene run/spec/lift.json --inventory run/inventory.json --masks other/masks.h5 --out x.h5 -- "written with a masks.h5"
  material() { "$bin/pm-material" --scene run/spec/material.json --inventory run/inventory.json --out x.json "$@"; }
  fails_with 3 material --masks other/masks.h5 --state run/state.h5 -- "written with a masks.h5"
  candidates() { "$bin/pm-candidates" --scene run/spec/candidates.json --inventory run/inventory.json --evidence run/evidence.json --out x "$@"; }
  fails_with 3 candidates --plan run/plan.json --state other/state.h5 -- "state.h5"
  fails_with 3 candidates --plan other/plan.json --state run/state.h5 -- "plan.json" "made from a inventory.json"
}

@test "hashes: an authored candidate and metrics are made from what was recorded" {
  mkdir other
  sed '1s/$/ /' run/inventory.json >other/inventory.json
  cat >configuration.json <<'J'
{"schema": "physmas/configuration/1",
 "rows": {"gaussians/gaussians": {"branch": "Jelly", "E": 1e6, "nu": 0.45, "rho": 1100}}, "actions": []}
J
  authored() { "$bin/pm-candidates" --scene run/spec/candidates.json --state run/state.h5 --configuration configuration.json --out x "$@"; }
  authored --inventory run/inventory.json
  rm -r x
  fails_with 3 authored --inventory other/inventory.json -- state.h5 "made from a inventory.json"
  [ ! -e x ]
  motion() { "$bin/pm-eval" motion --scene run/spec/render.json --inventory run/inventory.json --state run/state.h5 --out metrics.json "$@"; }
  motion --rollout run/rollouts/soft.h5 --reference run/rollouts/posterior.h5 >/dev/null
  rm metrics.json
  cp run/rollouts/soft.h5 kept
  flip run/rollouts/soft.h5
  fails_with 3 motion --rollout run/rollouts/soft.h5 --reference run/rollouts/posterior.h5 -- "soft.h5 with SHA-256"
  fails_with 3 motion --rollout run/rollouts/posterior.h5 --reference run/rollouts/soft.h5 -- "soft.h5 with SHA-256"
  # A rollout without a record is anyone's.
  cp kept foreign.h5
  motion --rollout foreign.h5 --reference run/rollouts/posterior.h5 >/dev/null
  fails_with 3 motion --inventory other/inventory.json --rollout foreign.h5 --reference foreign.h5 -- "made from a inventory.json"
}

@test "audit: recorded exchanges and material records of one's own are a run's inputs as well" {
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle --quiet
  serve good
  PM_API_KEY=pmkey-0123456789 run_make run SCENE=bundle/scene.json SPEC="$BATS_FILE_TMPDIR/spec.json" AGENT="$url" MODEL=tester RUN=asked >log 2>&1
  stop_server
  "$bin/pm-screen" --audit asked
  exchange=$(find asked -path '*exchanges*' -name '*.json' | sort | head -1)
  [ -n "$exchange" ]
  # An answer that was not given is found, in a replay as in the audit.
  sed -i 's/0.75/0.76/g' "$exchange"
  run "$bin/pm-screen" --audit asked
  [ "$status" -eq 3 ]
  [[ "$output" = *"$(basename "$exchange"): is not what"* ]]
  cat >records.json <<'J'
{"schema": "physmas/material_records/1",
 "rows": [{"key": "lollipop/candy", "crops": [{"E": 15000, "E_uncertainty": 0.1, "nu": 0.42, "nu_uncertainty": 0.03, "evidence": {"Rubber": 1}}]}]}
J
  run_make run SCENE=bundle/scene.json SPEC="$BATS_FILE_TMPDIR/spec.json" AUTHORED=records.json RUN=own >log 2>&1
  "$bin/pm-screen" --audit own
  sed -i 's/15000/25000/' records.json
  run "$bin/pm-screen" --audit own
  [ "$status" -eq 3 ]
  [[ "$output" = *"records.json: is not what"* ]]
}

@test "rerun: everything that a run promises is made again when it is gone" {
  cd "$BATS_FILE_TMPDIR"
  again() { make_run again >log; }
  # Every kind of file; of the candidates' only one.
  for file in $(cd one && find . -type f -not -path './.stamps/*' -not -path '*posterior*' -printf '%P\n' | sort); do
    rm -rf again
    cp -a one again
    rm "again/$file"
    again
    same_runs one again || { cat log; echo "$file was not made again"; return 1; }
    again
    grep -q '^Nothing to do' log || { cat log; echo "$file: made twice"; return 1; }
  done
  # Also where nothing is accepted: the best video.
  refused() { make_run refused SET=screening.tau=9 >log 2>&1 || true; }
  refused
  cp refused/best.mp4 kept
  rm refused/best.mp4
  refused
  cmp refused/best.mp4 kept
}
