load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

motion() { "$bin/pm-eval" motion --scene bundle/scene.json --inventory inventory.json --state state.h5 --rollout rollouts/support-stiff.h5 --reference rollouts/support-stiff.h5 --out metrics.json "$@"; }

@test "pm-eval: help and usage" {
  shows_help pm-eval
  fails_with 2 "$bin/pm-eval" -- "pm-eval"
  fails_with 2 motion --target nothing -- "--target" "lollipop"
}

@test "pm-eval stability: a subset, every run by cfl stable, no garbage, with its files" {
  "$bin/pm-eval" stability --quick --out stability >table.txt
  grep -q '^sweep  *cfl  *float' table.txt
  [ "$(head -1 stability/stability.csv | cut -d, -f1-4)" = "study,name,rule,precision" ]
  [ "$(grep -c ',cfl,' stability/stability.csv)" -gt 50 ]
  refute grep -E ',cfl,.*,diverged,' stability/stability.csv
  grep ',paper,' stability/stability.csv | grep -q ',diverged,'
  grep -q '"garbage": \[\]' stability/stability.json
  command -v gnuplot >/dev/null || skip "no gnuplot: everything but the plots was tested"
  [ -s stability/stability-paper-nu.png ]
}

@test "pm-eval stability: without gnuplot the numbers are there and a warning says what is missing" {
  mkdir -p empty
  PATH=$BATS_TEST_TMPDIR/empty "$bin/pm-eval" stability --quick --out bare >/dev/null 2>warning.txt
  grep -q 'make deps' warning.txt
  [ -s bare/stability.csv ]
  [ -s bare/stability.gp ]
  refute grep png <(ls bare)
}

@test "pm-eval motion: a run against itself has no error" {
  motion
  grep -A2 '"trajectory_nrmse"' metrics.json | grep -q '"value": 0.0'
  grep -A2 '"area_log_rmse"' metrics.json | grep -q '"value": 0.0'
  grep -A2 '"strain_rmse"' metrics.json | grep -q '"value": 0.0'
}

@test "pm-eval motion: a run of fewer frames is invalid, not zero" {
  "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out rollouts/short.h5 --frames 3
  motion --rollout rollouts/short.h5
  [ "$(grep -c '"status": "invalid"' metrics.json)" -eq 3 ]
  refute grep '"value"' metrics.json
}

@test "pm-eval motion: softer material moves differently" {
  # The candy at a tenth and at a hundredth of its modulus: the softer, the further from the reference in every metric.
  for E in 1e5 1e4; do
    sed -E "0,/\"E\": 1000000.0/s//\"E\": $E/" candidates/support-stiff.json >soft.json
    "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate soft.json --out rollouts/soft.h5
    motion --rollout rollouts/soft.h5 --target lollipop
    mv metrics.json "metrics-$E.json"
  done
  python3 - <<'PY'
import json
softer, softest = (json.load(open(f"metrics-{E}.json"))["metrics"] for E in ("1e5", "1e4"))
for name in ("trajectory_nrmse", "area_log_rmse", "strain_rmse"):
    assert 0.1 < softer[name]["value"] < softest[name]["value"] / 2, (name, softer[name], softest[name])
PY
}

@test "pm-eval accuracy: a quick study with its files" {
  "$bin/pm-eval" accuracy --quick --threads 1 --out study
  for name in jelly-drop plasticine-press sand-collapse two-object-impact soft-on-stiff; do
    grep -q "\"$name\"" study/accuracy.json
    grep -q "^$name,24,cfl,float,1,stable," study/accuracy.csv
  done
  grep -q '"processor"' study/accuracy.json
  grep -q '"pareto"' study/accuracy.json
  fails_with 2 "$bin/pm-eval" accuracy --out study --case nothing -- "nothing" "jelly-drop"
  command -v gnuplot >/dev/null || skip "no gnuplot: everything but the plots was tested"
  for metric in position trajectory area strain energy; do [ -s "study/accuracy-$metric.png" ]; done
}

@test "pm-eval verification: the coarsest resolutions, as a table and a record" {
  "$bin/pm-eval" verification --quick --out verification.json >table
  grep -q 'bar: frequency' table
  grep -q '"physmas/verification/1"' verification.json
}

@test "pm-eval error: a run on its grid, estimated by row and in the picture; bad input" {
  error() { "$bin/pm-eval" error --scene bundle/scene.json --view bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --out error.json "$@"; }
  # A quarter of 24 cells is no grid.
  fails_with 3 error --rollout rollouts/support-stiff.h5 -- /run/grid/n 32
  "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --grid 36 --out rollouts/fine.h5
  error --rollout rollouts/fine.h5 >table
  cat table
  grep -qE '^position +[0-9.]+ % of the scene' table
  grep -qE '^  lollipop/candy +[0-9.]+ % of its longest edge' table
  grep -q '"physmas/error/1"' error.json
  [ "$(grep -c '"status": "valid"' error.json)" -eq 6 ]
  python3 - <<'PY'
import json
record = json.load(open("error.json"))
assert [c["n"] for c in record["companions"]] == [18, 9]
position = record["measures"][0]
assert 0 < position["estimate"] <= position["bound"]
PY
  # The same bytes but for run times, whatever the threads.
  cp error.json first.json
  error --rollout rollouts/fine.h5 --threads 1 >/dev/null
  diff <(sed '/"runtime"/,$d' first.json) <(sed '/"runtime"/,$d' error.json)
  # Without a camera the picture's metrics have a reason.
  "$bin/pm-eval" error --scene bundle/scene.json --state state.h5 --candidate candidates/support-stiff.json --rollout rollouts/fine.h5 --out error.json >table
  grep -q '^strain_rmse  *none: no camera' table
  fails_with 2 "$bin/pm-eval" error --scene bundle/scene.json --state state.h5 --out x.json -- --accepted
  fails_with 2 error --rollout rollouts/fine.h5 --accepted accepted.json -- --accepted
  printf x >>rollouts/fine.h5
  fails_with 3 error --rollout rollouts/fine.h5 -- SHA-256
}
