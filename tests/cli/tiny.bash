# A tiny scene, run once per test file as far as the rollout of one candidate.
load common

# Makes $BATS_FILE_TMPDIR/run with everything up to rollouts/support-stiff.h5.
make_tiny_run() {
  local run=$BATS_FILE_TMPDIR/run
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out "$run/bundle"
  cd "$run" || return 1
  "$bin/pm-ground" --scene bundle/scene.json --out .
  "$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out state.h5
  "$bin/pm-material" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json
  "$bin/pm-candidates" --scene bundle/scene.json --inventory inventory.json --plan plan.json --evidence evidence.json --state state.h5 --out candidates
  simulate
}

# A private copy of that run for one test.
enter_tiny_run() {
  cp -r "$BATS_FILE_TMPDIR/run" "$BATS_TEST_TMPDIR/run"
  cd "$BATS_TEST_TMPDIR/run" || return 1
}

simulate() { "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out rollouts/support-stiff.h5 "$@"; }
render() { "$bin/pm-render" --scene bundle/scene.json --state state.h5 --rollout rollouts/support-stiff.h5 --out videos/support-stiff.mp4 "$@"; }

# Changes a JSON file in place.
edit() { # FILE SED-EXPRESSION
  sed -i -E "$2" "$1"
}
