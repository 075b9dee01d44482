bats_require_minimum_version 1.5.0
load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

@test "pm-simulate: help and usage" {
  shows_help pm-simulate
  fails_with 2 "$bin/pm-simulate" -- "--scene"
  fails_with 2 simulate --nonsense -- "--nonsense"
  fails_with 2 simulate --precision half -- "half"
  fails_with 2 simulate --energy some -- "some"
  fails_with 2 simulate --timestep soon -- "--timestep" "soon"
  fails_with 2 simulate --timestep cfll -- "cfl"
  fails_with 2 simulate --max-steps 0 -- "--max-steps"
  fails_with 2 simulate --device tpu -- "tpu"
  fails_with 2 simulate --out rollouts/x.txt -- ".h5"
}

# A build with kernels refuses for another reason, and where there is a card it does not.
@test "pm-simulate: where there is no GPU, cuda is refused in one sentence, and auto takes the CPU and says why" {
  if nvidia-smi >nvidia.log 2>&1; then skip "there is a card"; fi
  fails_with 2 simulate --device cuda -- "--device cuda: " "expected cpu or auto"
  simulate --device auto --out rollouts/auto.h5
  grep -q '"device": "cpu"' rollouts/auto.json
  grep -q '"device_reason": "at most .* s of work: less than a GPU is worth starting for"' rollouts/auto.json
  simulate --device cpu --out rollouts/cpu.h5
  grep -q '"device_reason": "asked for"' rollouts/cpu.json
  cmp rollouts/auto.h5 rollouts/cpu.h5
}

@test "pm-simulate: a rollout and its record" {
  [ -s rollouts/support-stiff.h5 ]
  grep -q '"status": "stable"' rollouts/support-stiff.json
  grep -q '"frames": 10' rollouts/support-stiff.json
  grep -q '"particle_steps_per_second"' rollouts/support-stiff.json
}

@test "pm-simulate: equal input gives equal bytes, whatever the thread count, and keeps the timestamp" {
  before=$(stat -c %y rollouts/support-stiff.h5)
  sleep 0.05
  simulate --threads 1
  simulate --threads 3
  [ "$(stat -c %y rollouts/support-stiff.h5)" = "$before" ]
}

@test "pm-simulate: a diverged simulation is a result, and an error with --strict" {
  # 3e11 Pa at the step of a softer candidate cannot be integrated.
  edit candidates/support-stiff.json 's/"E": [0-9.e+]+/"E": 3e11/'
  simulate --quiet
  grep -q '"status": "diverged"' rollouts/support-stiff.json
  grep -Eq '"first_bad_step": [0-9]+' rollouts/support-stiff.json
  run simulate --strict
  [ "$status" -eq 5 ]
}

@test "pm-simulate: --timestep cfl integrates what the candidate's step cannot, within a budget" {
  edit candidates/support-stiff.json 's/"E": [0-9.e+]+/"E": 1e9/'
  simulate --timestep cfl --frames 2 --quiet
  grep -q '"status": "stable"' rollouts/support-stiff.json
  grep -q '"rule": "cfl"' rollouts/support-stiff.json
  grep -Eq '"smallest_dt": [0-9.e-]+' rollouts/support-stiff.json
  grep -q '"retries"' rollouts/support-stiff.json
  simulate --timestep cfl --frames 2 --max-steps 10 --quiet
  grep -q '"budget"' rollouts/support-stiff.json
  grep -q -- '--max-steps' rollouts/support-stiff.json
  run simulate --timestep cfl --frames 2 --max-steps 10 --strict
  [ "$status" -eq 5 ]
}

@test "pm-simulate: a divergence names the row and what to set; time.on_divergence tries once more, within a budget" {
  edit candidates/support-stiff.json 's/"E": [0-9.e+]+/"E": 1e9/'
  run --separate-stderr simulate --frames 2
  [ "$status" -eq 0 ]
  [[ $stderr = *"support-stiff: the motion breaks down before frame 1 of 1: lollipop/"*" (E 1 GPa) is too stiff for substeps of "*" s, it needs "*'try SET="time.rule=cfl"'* ]]
  [ "$(wc -l <<<"$stderr")" -eq 1 ]
  grep -A4 '"divergence"' rollouts/support-stiff.json | grep -q '"cause": "step"'
  refute grep '"attempts"' rollouts/support-stiff.json
  edit bundle/scene.json 's/"on_divergence": "stop"/"on_divergence": "cfl"/'
  run --separate-stderr simulate --frames 2
  [[ $stderr = *"once more with time.rule=cfl"* ]]
  grep -q '"status": "stable"' rollouts/support-stiff.json
  grep -q '"rule": "cfl"' rollouts/support-stiff.json
  grep -A20 '"attempts"' rollouts/support-stiff.json | grep -Eq '"reason": "[a-z]+ in substep [0-9]+"'
  refute grep '"divergence"' rollouts/support-stiff.json
  # What was asked for on the command line is not tried in another way.
  simulate --frames 2 --timestep paper --quiet
  grep -q '"status": "diverged"' rollouts/support-stiff.json
  edit bundle/scene.json 's/"retry_substeps": 40000/"retry_substeps": 10/'
  run --separate-stderr simulate --frames 2
  [[ $stderr = *"the 10 substeps of time.retry_substeps"* ]]
  grep -q '"status": "diverged"' rollouts/support-stiff.json
  grep -A20 '"attempts"' rollouts/support-stiff.json | grep -q 'more than 10 substeps, which time.retry_substeps allows'
}

@test "pm-simulate: the run's time.rule chooses the step rule, --timestep wins" {
  edit bundle/scene.json 's/"rule": "paper"/"rule": "cfl"/'
  simulate --frames 2
  grep -q '"rule": "cfl"' rollouts/support-stiff.json
  simulate --frames 2 --timestep paper
  grep -q '"rule": "paper"' rollouts/support-stiff.json
}

@test "pm-simulate: options change the numerics and are recorded" {
  simulate --precision double --grid 20 --frames 3 --timestep 4e-4
  grep -q '"precision": "double"' rollouts/support-stiff.json
  grep -q '"per_frame": 100' rollouts/support-stiff.json
  grep -q '"frames": 3' rollouts/support-stiff.json
}

@test "pm-simulate: the energy budget is measured as asked" {
  simulate --frames 3 --energy off
  grep -q '"measured": "off"' rollouts/support-stiff.json
  grep -q '"J_range": null' rollouts/support-stiff.json
  grep -q '"elastic": \[\]' rollouts/support-stiff.json
  refute grep '"residual"' rollouts/support-stiff.json
  simulate --frames 3
  grep -q '"measured": "frames"' rollouts/support-stiff.json
  grep -q '"relative": ' rollouts/support-stiff.json
  refute grep '"budget"' rollouts/support-stiff.json
  simulate --frames 3 --energy steps
  grep -q '"measured": "steps"' rollouts/support-stiff.json
  for term in change transfer contact plastic viscous projection control structure residual largest_step; do
    grep -q "\"$term\": " rollouts/support-stiff.json
  done
}

@test "pm-simulate: missing and malformed inputs" {
  fails_with 3 simulate --scene missing.json -- "missing.json" "No such file"
  echo '{"schema": ' >bad.json
  fails_with 3 simulate --scene bad.json -- "bad.json" "line" "malformed"
  fails_with 3 simulate --scene inventory.json -- "/schema" "physmas/inventory/1" "physmas/scene/1"
  fails_with 3 simulate --candidate plan.json -- "/schema" "physmas/candidate/1"
  edit candidates/support-stiff.json 's/"round": 0/"round": 0, "colour": "red"/'
  fails_with 3 simulate -- "colour"
}

@test "pm-simulate: impossible candidates" {
  cp candidates/support-stiff.json good.json
  edit candidates/support-stiff.json '0,/"nu": [0-9.]+/s//"nu": 0.5/'
  fails_with 3 simulate -- "/rows/0/nu" "0.5"
  cp good.json candidates/support-stiff.json
  edit candidates/support-stiff.json '0,/"E": [0-9.e+]+/s//"E": -1/'
  fails_with 3 simulate -- "/rows/0/E" "-1"
  cp good.json candidates/support-stiff.json
  edit candidates/support-stiff.json 's#lollipop/candy#lollipop/sugar#'
  fails_with 3 simulate -- "lollipop/sugar"
}

@test "pm-simulate: HDF5 that is cut short or of another shape" {
  head -c 1000 state.h5 >cut.h5
  fails_with 3 simulate --state cut.h5 -- "cut.h5" "HDF5"
  fails_with 3 simulate --state rollouts/support-stiff.h5 -- "/@schema" "physmas/rollout/1"
  echo "not HDF5" >text.h5
  fails_with 3 simulate --state text.h5 -- "text.h5"
}

@test "pm-simulate: a place that cannot be written leaves nothing" {
  touch file
  fails_with 3 simulate --out file/x.h5 -- "file/x.h5"
  mkdir full
  mount -t tmpfs -o size=16k tmpfs full 2>/dev/null || skip "no full disk: tmpfs cannot be mounted here"
  status=0
  fails_with 3 simulate --out full/x.h5 -- "full/x.h5" || status=$?
  left=$(ls -A full)
  umount full
  [ "$status" -eq 0 ]
  [ -z "$left" ]
}

@test "pm-simulate: time.start: equilibrium is recorded, whatever the thread count, and a rest is not" {
  refute grep '"start": [{]' rollouts/support-stiff.json
  cp rollouts/support-stiff.h5 rest.h5
  edit bundle/scene.json 's/"start": "rest"/"start": "equilibrium"/'
  simulate --threads 1
  grep -q '"rule": "equilibrium"' rollouts/support-stiff.json
  for field in supported_parts free_parts supported_particles iterations corrections residual largest_strain limited; do
    grep -q "\"$field\": " rollouts/support-stiff.json
  done
  refute cmp -s rest.h5 rollouts/support-stiff.h5
  cp rollouts/support-stiff.h5 one.h5
  simulate --threads 3
  cmp one.h5 rollouts/support-stiff.h5
  edit bundle/scene.json 's/"start": "equilibrium"/"start": "standing"/'
  fails_with 3 simulate -- "/run/time/start" "standing"
}
