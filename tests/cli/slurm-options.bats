#!/usr/bin/env bats
# The executor slurm's table of resources, and what of it reaches srun; without a Slurm.
load common

setup() {
  cd "$BATS_TEST_TMPDIR" || return 1
  mkdir path
  # What Slurm does not take is not tried again.
  printf '#!/bin/bash\nprintf "%%s " "$@" >>%q\necho >>%q\necho "srun: error: Invalid partition name" >&2\nexit 1\n' "$PWD/srun.log" "$PWD/srun.log" >path/srun
  chmod +x path/srun
  export PATH=$PWD/path:$PATH SLURM_CONF=$PWD/none
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out scene --quiet
}

run_make() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$bin" EXECUTOR=slurm "$@"; }
refuses() { # TEXT ARGUMENT...
  local text=$1
  shift
  run run_make run SCENE=scene/scene.json RUN=run "$@"
  echo "$output"
  [ "$status" -eq 2 ]
  [ "${#lines[@]}" -eq 1 ]
  [[ $output = *"$text"* ]]
  [ ! -e run ]
}

@test "slurm: lines of the table that cannot be read are named" {
  for line in 'lift 1 core' 'lift: 1 core' 'lift: 0 cores, 1 GiB, 1 min' 'lift: 1 core, 1 GB, 1 min' 'lift: 1 core, 1 GiB, 1 min, --wrap=$(x)' 'lift: here, 1 core' \
    'lift: 2 cores, 99999999999 MiB, 1 min'; do
    printf '# a comment\n%s\n' "$line" >table
    refuses "table:2: found \"" RESOURCES=table
  done
  refuses "RESOURCES=nowhere is not there" RESOURCES=nowhere
  refuses "RETRY=twice: expected memory, time, or both" RETRY=twice
  refuses "ARRAY=x: expected a number" ARRAY=x
  refuses "make run has no variable RETYR; the nearest is RETRY" RETYR=memory
}

@test "slurm: cores, memory, time, GPUs and options of a stage reach srun" {
  cat >table <<'T'
default: 3 cores, 700 MiB, 90 s   # for the rest
ground: 5 cores, 2 GiB, 1 h, 2 gpus, --partition=long
T
  job() { # NAME STAGE COMMAND...
    PM_RESOURCES="$root/pipelines/executors/resources.txt table" PM_PATIENCE=1 bash "$root/pipelines/executors/slurm-job.sh" "$1" "$2" "" "" "$PWD/run/.stamps/$1.log" $$ -- "${@:3}"
  }
  mkdir -p run/.stamps
  run job ground ground pm-ground
  [ "$status" -eq 2 ]
  [[ $output = *"srun: error: Invalid partition name"*"run/ground: error: Slurm does not take it"* ]]
  grep -q -- '--cpus-per-task=5 --mem=2048M .*--time=62 --gres=gpu:2 --partition=long ' srun.log
  : >srun.log
  run job newstage newstage pm-x
  [ "$status" -eq 2 ]
  grep -q -- '--cpus-per-task=3 --mem=700M .*--time=4 ' srun.log
  refute grep -q gres srun.log
  : >srun.log
  run job simulate-x simulate pm-simulate --device cuda --out x
  [ "$status" -eq 2 ]
  grep -q -- '--cpus-per-task=8 --mem=2048M .*--gres=gpu:1 ' srun.log
  : >srun.log
  run job screen0 screen bash -c 'echo here'
  [ "$output" = here ]
  [ ! -s srun.log ]
  # No key on a command line, and none in a file.
  : >srun.log
  PM_API_KEY=geheim run job lift lift pm-lift
  [ "$status" -eq 2 ]
  [ -s srun.log ]
  refute grep -rq geheim .
  [ -z "$(find run -name '*.job*')" ]
}

@test "slurm: an out-of-memory kill is called so in each of Slurm's words, and only in Slurm's" {
  mkdir -p run/.stamps
  cat >path/srun <<'SRUN'
#!/bin/bash
printf '%s ' "$@" >>srun.log
echo >>srun.log
cat said >&2
exit 137
SRUN
  job() { PM_RESOURCES="$root/pipelines/executors/resources.txt" PM_PATIENCE=1 bash "$root/pipelines/executors/slurm-job.sh" lift lift "" "" "$PWD/run/.stamps/lift.log" $$ -- pm-lift; }
  for said in 'slurmstepd-n1: error: Detected 1 oom_kill event in StepId=12.0. Some of the step tasks have been OOM Killed.' \
    'slurmstepd: error: Detected 2 oom-kill event(s) in StepId=12.0. Some of your processes may have been killed by the cgroup out-of-memory handler.' \
    'srun: error: n1: task 0: Out Of Memory' 'slurmstepd: error: StepId=12.0 exceeded memory limit (9000 > 4096), being killed'; do
    echo "$said" >said
    : >srun.log
    run job
    echo "$output"
    [ "$status" -eq 137 ]
    [[ $output = *"run/lift: error: out of memory: its 4096 MiB on its node were too few"*RETRY=memory* ]]
    [ "$(wc -l <srun.log)" -eq 1 ]
  done
  PM_RETRY=memory run job
  [ "$status" -eq 137 ]
  [[ $output = *"once more with 8192 MiB"*"its 8192 MiB"* ]]
  grep -q -- '--mem=8192M' srun.log
  # Of the command's own words nothing follows: it was lost with its node.
  echo 'pm-lift: Out Of Memory' >said
  timeout 8 bash -c 'export PM_RESOURCES=$1/pipelines/executors/resources.txt PM_PATIENCE=1; bash "$1/pipelines/executors/slurm-job.sh" lift lift "" "" "$PWD/run/.stamps/lift.log" $$ -- pm-lift' - "$root" >log 2>&1 || true
  grep -q 'lost with its node; once more' log
}
