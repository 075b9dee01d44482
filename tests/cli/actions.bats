# Every action of the vocabulary, from a prompt to a rollout, on a tiny scene; and the two options of a run that change
# what a rollout holds.
load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

# run_prompt PROMPT: plan, candidates and a short simulation of the one that stays stable on this coarse grid.
run_prompt() {
  sed -i "s/\"prompt\": \"[^\"]*\"/\"prompt\": \"$1\"/" bundle/scene.json
  "$bin/pm-ground" --quiet --scene bundle/scene.json --out .
  "$bin/pm-lift" --quiet --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out state.h5
  make_candidates
  "$bin/pm-simulate" --quiet --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out rollouts/support-stiff.h5 --frames 8
}
make_candidates() {
  "$bin/pm-material" --quiet --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json
  "$bin/pm-candidates" --quiet --scene bundle/scene.json --inventory inventory.json --plan plan.json --evidence evidence.json --state state.h5 --out candidates
}
runs_as() { # PROMPT ACTION...
  run_prompt "$1"
  shift
  for action in "$@"; do
    grep -q "\"type\": \"$action\"" plan.json || { echo "no $action in the plan"; return 1; }
    grep -q "\"operation\": \"$action\"" candidates/support-stiff.json || { echo "no $action in the candidate"; return 1; }
  done
  grep -q '"status": "stable"' rollouts/support-stiff.json
  # The controls moved something: nothing is omitted for want of actions.
  refute grep -q '"what": "actions"' rollouts/support-stiff.json
}

@test "actions: push, press, hit" {
  runs_as "push the lollipop to the left" translation
  runs_as "press the lollipop" top_press
  runs_as "kick the lollipop to the right" impulse
}

@test "actions: melt, flatten, squeeze" {
  runs_as "the candy melts" radial_spread
  runs_as "flatten the candy" vertical_compress
  runs_as "squeeze the candy" side_compress
}

@test "actions: drag, stretch" {
  runs_as "drag the lollipop to the right" drag_pair
  runs_as "stretch the candy" scale
}

@test "actions: twist, spin, hold" {
  runs_as "twist the lollipop" torque support_hold
  runs_as "hold the stick and spin the candy" torque support_hold
}

# achieved KEY: that of every action in the record, one per line.
achieved() { python3 -c 'import json, sys; [print(a.get(sys.argv[1], "")) for a in json.load(open("rollouts/support-stiff.json"))["achieved"]]' "$1"; }

@test "actions: what each achieved stands beside its request" {
  run_prompt "push the lollipop to the left at 1 m\/s for 0.2 s"
  [ "$(achieved type)" = translation ]
  [ "$(achieved quantity)" = displacement ]
  [ "$(achieved rows)" = "['lollipop/candy', 'lollipop/stick']" ]
  [ "$(achieved requested)" = 0.2 ]
  # Enforced: what was asked is what happens, to the rounding of float.
  python3 -c "assert abs($(achieved achieved) - 0.2) < 1e-5 and $(achieved share) > 0.9999"
  [ -z "$(achieved shortfall)" ]
  grep -q '"stillness": null' rollouts/support-stiff.json

  # The run is over before the action: one line says so.
  run_prompt "push the lollipop to the left at 1 m\/s for 0.3 s"
  cp rollouts/support-stiff.json whole.json
  "$bin/pm-simulate" --log-level warning --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out rollouts/support-stiff.h5 --frames 3 2>err
  [ "$(wc -l <err)" -eq 1 ]
  grep -q 'support-stiff: translation of lollipop/candy, lollipop/stick: displacement 0.08 of 0.3 m: the run ended before its end' err
  achieved shortfall | grep -q 'the run ended before its end'
}

@test "actions: a plan without actions leaves what stands to be still" {
  python3 - <<'PY'
import json
d = json.load(open("bundle/scene.json"))
d["run"]["gravity"] = [0, 0, 0]
json.dump(d, open("bundle/scene.json", "w"))
PY
  simulate --quiet --frames 4
  [ -z "$(achieved type)" ]
  python3 - <<'PY'
import json
still = json.load(open("rollouts/support-stiff.json"))["stillness"]
assert still["rows"] == ["lollipop/candy", "lollipop/stick"], still
assert still["drift"] == 0 and still["share"] == 1, still
PY
  # What an action moves, or touches while it moves, is not among it.
  run_prompt "push the candy to the left"
  grep -q '"stillness": null' rollouts/support-stiff.json
}

# set_run KEY JSON: a section of the scene's run specification.
set_run() {
  python3 - "$1" "$2" <<'PY'
import json, sys
d = json.load(open("bundle/scene.json"))
d["run"][sys.argv[1]] = json.loads(sys.argv[2])
json.dump(d, open("bundle/scene.json", "w"))
PY
}

@test "actions: what is too stiff for a bounded force is turned all the same; where it shall not be, a line says so" {
  run_prompt "twist the lollipop"
  grep -q '"drive": "enforced"' candidates/support-stiff.json
  grep -q '"release": 0.25' candidates/support-stiff.json
  python3 -c "assert $(achieved share | sed -n 1p) > 0.99"
  [ -z "$(achieved shortfall)" ]
  set_run controls '{"stiff": "blended", "release": "literal"}'
  make_candidates
  grep -q '"drive": "blended"' candidates/support-stiff.json
  grep -q '"release": 0.0' candidates/support-stiff.json
  simulate --frames 8 --quiet
  python3 -c "assert $(achieved share | sed -n 1p) < 0.9"  # a stick of a few particles is not that stiff

  # A squeeze is a bounded force for whatever is squeezed.
  run_prompt "squeeze the candy"
  edit candidates/support-stiff.json 's/"E": 1000000.0/"E": 10000000.0/'
  simulate --frames 8 2>err
  [ "$(grep -c 'support-stiff: side_compress of lollipop/candy: ratio 0.9[0-9]* of 0.65: its bounded force does not move Jelly of 1e+07 Pa; choose a softer material (MATERIAL=)$' err)" -eq 2 ]
  set_run controls '{"stiff": "broken"}'
  fails_with 3 simulate -- "/run/controls/stiff" "broken"
}

@test "actions: equal input gives equal bytes for any number of threads" {
  run_prompt "twist the lollipop"
  before=$(sha256sum <rollouts/support-stiff.h5)
  for threads in 1 2; do
    "$bin/pm-simulate" --quiet --threads $threads --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out rollouts/support-stiff.h5 --frames 8
    [ "$(sha256sum <rollouts/support-stiff.h5)" = "$before" ]
  done
}

@test "run options: rigid projection and total deformation are recorded where they act" {
  grep -q '"mode": "literal"' candidates/rigid-support.json
  grep -q '"deformation": "elastic"' rollouts/support-stiff.json
  sed -i 's/"mode": "literal"/"mode": "rigid"/; s/"deformation": "elastic"/"deformation": "total"/' bundle/scene.json
  make_candidates
  grep -q '"mode": "rigid"' candidates/rigid-support.json
  "$bin/pm-simulate" --quiet --scene bundle/scene.json --state state.h5 --candidate candidates/rigid-support.json --out rollouts/rigid-support.h5
  grep -q '"deformation": "total"' rollouts/rigid-support.json
  grep -q '"status": "stable"' rollouts/rigid-support.json
  sed -i 's/"mode": "rigid"/"mode": "bent"/' bundle/scene.json
  fails_with 3 simulate -- "/run/projection/mode" "bent"
}

@test "actions: operations that make no sense are refused" {
  run_prompt "twist the lollipop"
  cp candidates/support-stiff.json good.json
  once() { "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out rollouts/support-stiff.h5; }
  edit candidates/support-stiff.json 's/"blend_time": [0-9.e-]+/"blend_time": 0/'
  fails_with 3 once -- "/schedule/0/blend_time"
  cp good.json candidates/support-stiff.json
  edit candidates/support-stiff.json 's/"rate": [0-9.e-]+/"rate": 1e9/'
  fails_with 3 once -- "/schedule/0/rate"
  cp good.json candidates/support-stiff.json
  edit candidates/support-stiff.json '/"rate"/d'
  fails_with 3 once -- "/schedule/0" "rate of torque"
  cp good.json candidates/support-stiff.json
  python3 - <<'PY'
import json
d = json.load(open("candidates/support-stiff.json"))
d["schedule"][0]["direction"] = [0, 0, 0]
json.dump(d, open("candidates/support-stiff.json", "w"))
PY
  fails_with 3 once -- "/schedule/0/direction" "unit vector"
}
