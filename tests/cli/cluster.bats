#!/usr/bin/env bats
# The executor slurm on a real Slurm: the bytes of the executor local, and what happens when nodes, clocks, disks and people fail.
load common
load cluster

setup_file() {
  start_cluster
  cd "$BATS_FILE_TMPDIR" || return 1
  make_scenes a b c
  make_tricky_tools
  run_make run SCENE=a/scene.json SPEC=spec.json RUN=run 2>log
  run_make -j2 batch SCENES="a/scene.json b/scene.json c/scene.json" SPEC=spec.json BATCH=batch 2>log
  mkdir local
  mv run batch local/
}
teardown_file() { stop_cluster; }

setup() {
  cd "$BATS_FILE_TMPDIR" || return 1
  rm -rf run batch tricks path prolog.*
  mkdir tricks
  for daemon in slurmctld n1 n2 n3; do slurm revive $daemon; done
}

scenes="a/scene.json b/scene.json c/scene.json"

@test "cluster: jobs, steps of an allocation and workers of an array give the bytes of one machine" {
  run_slurm -j6 batch SCENES="$scenes" SPEC=spec.json BATCH=batch
  nothing_left batch
  same_results local/batch batch
  # Heavy stages ran on nodes, light ones did not.
  [ "$(grep -cE '^n[123] pm-(ground|lift|simulate|render) ' tricks/calls)" -ge 18 ]
  refute grep -E '^n[123] pm-(candidates|screen) ' tricks/calls
  run_slurm batch SCENES="$scenes" SPEC=spec.json BATCH=batch >log
  grep -q '^Nothing to do: 3 of 3' log

  rm -rf batch
  salloc --quiet --nodes=3 --ntasks=6 --mem=2000 env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$PWD/tools" THREADS=1 \
    EXECUTOR=slurm RESOURCES=resources -j6 batch SCENES="$scenes" SPEC=spec.json BATCH=batch
  nothing_left batch
  same_results local/batch batch

  rm -rf batch
  run_slurm -j6 batch SCENES="$scenes" SPEC=spec.json BATCH=batch ARRAY=3
  nothing_left batch
  same_results local/batch batch
}

@test "cluster: a node that dies in the middle, and a worker's" {
  for array in 0 3; do
    rm -rf run tricks/*
    # The first that simulates on a node waits, and its node is killed.
    cat >tricks/pm-simulate.before <<'TRICK'
if mkdir "$tricks/victim" 2>/dev/null; then echo "$node" >"$tricks/node"; sleep 60; fi
TRICK
    run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run ARRAY=$array >log 2>&1 3>&- &
    make=$!
    for _ in {1..200}; do [ ! -e tricks/node ] || break; sleep 0.1; done
    [ -e tricks/node ] || { cat log; squeue; return 1; }
    node=$(<tricks/node)
    slurm kill "$node"
    sleep 1
    slurm revive "$node"
    wait $make || { cat log; return 1; }
    nothing_left run
    same_results local/run run
    grep -q 'lost with' log
  done
}

@test "cluster: a disk that is full on one node is none of the scene's faults" {
  cat >tricks/any.before <<TRICK
if [ "\$node" = n1 ]; then export LD_PRELOAD=${PM_TEST_BIN:-$bin/../test}/failing_calls.so PM_FAULT=write PM_FAULT_AT=1 PM_FAULT_ERROR=28 PM_FAULT_STAYS=1; fi
TRICK
  run_slurm -j1 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1 || { cat log; return 1; }
  grep -q 'no space left on the device of n1; once more' log
  same_results local/run run
  [ -z "$(find run -name '.*.tmp*')" ]
}

@test "cluster: clocks of nodes that are two minutes off neither hide work nor make any" {
  for shift in -120 120; do
    rm -rf run tricks/*
    # What a tool wrote on a node has that node's time.
    cat >tricks/any.after <<TRICK
if [ "\$node" != here ]; then find run -type f -newermt '-3 seconds' ! -path '*/.*' -exec bash -c 'for f; do touch -c -d "@\$((\$(stat -c %Y "\$f") + $shift))" "\$f"; done' - {} +; fi
TRICK
    run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1
    same_results local/run run
    grep -q '^n[123] pm-render' tricks/calls
    run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1
    grep -q '^Nothing to do' log
    # A change counts, however soon it comes.
    run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run SET="time.frames=3" >log 2>&1
    run_make run SCENE=a/scene.json SPEC=spec.json RUN=other SET="time.frames=3" >log 2>&1
    same_results other run
    rm -rf other
  done
}

@test "cluster: what files hold decides, where their times say something else" {
  run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1
  : >tricks/calls
  # Copied by something that loses times, or written under another clock.
  find run -type f -exec touch -d '+2 minutes' {} +
  touch -d '-2 minutes' run/.stamps/lift run/rollouts/*.h5
  run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1
  cat log tricks/calls
  grep -q '^Nothing to do' log
  [ ! -s tricks/calls ]
  # An older time hides no change.
  sed -i -E 's/"E": ([0-9])/"E": 1\1/' run/candidates/hard-support-bonded.json
  touch -d '-1 hour' run/candidates/hard-support-bonded.json
  run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1 || true
  grep -q 'pm-simulate .*hard-support-bonded' tricks/calls
  refute grep -q 'pm-simulate .*posterior' tricks/calls
}

@test "cluster: time-outs and too little memory are called so, and tried again with more where that is asked for" {
  cp resources table
  echo 'lift: 1 core, 300 MiB, 2 s' >>table
  echo 'material: 1 core, 100 MiB, 2 min' >>table
  echo 'sleep 3' >tricks/pm-lift.before
  echo 'python3 -c "import time; x = bytearray(220 << 20); time.sleep(3)"' >tricks/pm-material.before
  with_table() { run_make EXECUTOR=slurm RESOURCES=table SPEC=spec.json "$@"; }
  run with_table run SCENE=a/scene.json RUN=run
  echo "$output"
  [ "$status" -ne 0 ]
  [[ $output = *"run/lift: error: time-out: it was not done after its 2 s on n"*RESOURCES* ]]
  run with_table run SCENE=a/scene.json RUN=run RETRY=time
  echo "$output"
  [ "$status" -ne 0 ]
  [[ $output = *"run/lift: ended after its 2 s on n"*"once more with 4 s"* ]]
  [[ $output = *"run/material: error: out of memory: its 100 MiB on n"* ]]
  run with_table run SCENE=a/scene.json RUN=run RETRY="memory time"
  echo "$output"
  [ "$status" -ne 0 ]
  [[ $output = *"once more with 200 MiB"*"error: out of memory: its 200 MiB"* ]]
  echo 'material: 1 core, 200 MiB, 2 min' >>table
  with_table run SCENE=a/scene.json RUN=run RETRY="memory time" >log 2>&1
  same_results local/run run
  # In a batch it is the row's reason.
  with_table batch SCENES=a/scene.json BATCH=batch
  grep -q 'error: time-out: it was not done after its 2 s' batch/table.tsv
}

@test "cluster: Ctrl-C, kill and scancel leave no job, and the next make goes on" {
  echo 'sleep 30' >tricks/pm-simulate.before
  for how in INT TERM KILL wrapper shell scancel; do
    # A session of its own, whose processes do not ignore SIGINT.
    python3 -c 'import os, signal, sys; os.setsid(); signal.signal(signal.SIGINT, signal.SIG_DFL); os.execvp(sys.argv[1], sys.argv[1:])' \
      env -u MAKEFLAGS make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$PWD/tools" THREADS=1 EXECUTOR=slurm RESOURCES=resources \
      -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1 3>&- &
    make=$!
    for _ in {1..200}; do [ "$(find run/.stamps -name 'simulate*.where' 2>/dev/null | wc -l)" -eq 0 ] || break; sleep 0.1; done
    [ "$(find run/.stamps -name 'simulate*.where' | wc -l)" -gt 0 ] || { cat log; return 1; }
    case $how in
      INT) kill -INT -- -$make ;;
      TERM) kill -TERM $make ;;
      KILL) kill -KILL -- -$make ;;
      wrapper)
        for pid in $(grep -la 'slurm-job.sh' /proc/[0-9]*/cmdline 2>/dev/null | cut -d/ -f3); do
          if grep -zqxF "SLURM_CONF=$SLURM_CONF" "/proc/$pid/environ" 2>/dev/null; then kill -KILL "$pid"; fi
        done
        ;;
      shell) for pid in $(ps -o pid= --ppid $make); do kill -KILL "$pid"; done ;;
      scancel) scancel --user "$(id -un)" ;;
    esac
    wait $make || true
    nothing_left run || { echo "after $how"; return 1; }
  done
  cat log
  grep -q 'error: was cancelled on n' log
  rm tricks/pm-simulate.before
  run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1
  same_results local/run run
}

@test "cluster: two makes do not work on one run" {
  echo 'sleep 4' >tricks/pm-lift.before
  run_slurm run SCENE=a/scene.json SPEC=spec.json RUN=run >log 2>&1 3>&- &
  make=$!
  for _ in {1..100}; do [ ! -e run/.stamps/lift.job ] || break; sleep 0.1; done
  run run_slurm run SCENE=a/scene.json SPEC=spec.json RUN=run
  echo "$output"
  [ "$status" -eq 2 ]
  [[ $output = *"another make waits for the job run/lift"* ]]
  wait $make
  same_results local/run run
}

@test "cluster: what no node has is refused before anything runs, with the line of the table" {
  for case in 'lift: 99 cores, 1 GiB, 2 min|lift asks for 99 cores and 1024 MiB, which no node of the partition all has: the largest, n1 has 2 cores and 4000 MiB' \
    'lift: 1 core, 99 GiB, 2 min|lift asks for 1 core and 101376 MiB, which no node of the partition all has' \
    'lift: 1 core, 1 GiB, 2 h, --partition=urgent|lift asks for 7200 s: the partition urgent gives 1:00:00'; do
    cp resources table
    echo "${case%|*}" >>table
    run run_make EXECUTOR=slurm RESOURCES=table run SCENE=a/scene.json SPEC=spec.json RUN=run
    echo "$output"
    [ "$status" -eq 2 ]
    [ "${#lines[@]}" -eq 1 ]
    [[ $output = *"table:$(wc -l <table): ${case#*|}"*RESOURCES* ]]
    [ ! -e run ]
  done
  # What this goal does not ask for may be anything, and so may a Slurm that does not answer.
  limits() { PM_RESOURCES="resources table" bash "$root/pipelines/executors/slurm-limits.sh" "$@"; }
  limits simulate render default
  refute limits simulate lift
  SLURM_CONF=/nowhere limits lift
}

@test "cluster: Slurm's refusals come at once and in its words" {
  for option in --constraint=nothing "1 gpu"; do
    cp resources table
    echo "lift: 1 core, 300 MiB, 2 min, $option" >>table
    run run_make EXECUTOR=slurm RESOURCES=table run SCENE=a/scene.json SPEC=spec.json RUN=run
    echo "$output"
    [ "$status" -ne 0 ]
    [[ $output = *"srun: error: "*"Invalid "*"run/lift: error: Slurm does not take it"* ]]
    nothing_left run
    rm -r run
  done
}

@test "cluster: a job that is preempted or requeued is done again" {
  for how in "preempt 0" "preempt 3" "requeue 3"; do
    rm -rf run tricks/*
    cat >tricks/pm-simulate.before <<'TRICK'
if mkdir "$tricks/victim" 2>/dev/null; then echo "$node" >"$tricks/node"; sleep 60; fi
TRICK
    run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run ARRAY="${how#* }" >log 2>&1 3>&- &
    make=$!
    for _ in {1..200}; do [ ! -s tricks/node ] || break; sleep 0.1; done
    node=$(<tricks/node)
    case $how in
      preempt*) srun --quiet --partition=urgent --nodelist="$node" --nodes=1 --ntasks=1 --cpus-per-task=2 --mem=3900 --time=1 true ;;
      requeue*) scontrol requeue "$(squeue --noheader --array --states=running --nodelist="$node" --format=%i | head -n 1)" ;;
    esac
    wait $make || { cat log; return 1; }
    nothing_left run || { cat log; return 1; }
    same_results local/run run
    cat log
    grep -q "lost with $node; once more" log
  done
}

@test "cluster: files that are seen late are waited for, and not for ever" {
  # The node's own look at what it wrote takes a file away from all others, but for its beginning; `give_back` brings it a while later.
  mkdir path
  cat >path/stat <<STAT
#!/bin/bash
tricks=$(printf %q "$PWD/tricks")
format=\$2 last=\${!#}
if [ -n "\${SLURMD_NODENAME:-}" ] && [ -e "\$tricks/blind" ] && [[ \$format = %s && \$* = *rollouts/*.h5* ]]; then exit 1; fi
$(command -v stat) "\$@"
status=\$?
if [ -n "\${SLURMD_NODENAME:-}" ] && [ -d "\$tricks/late" ] && [ "\$format" = '%s %n' ]; then
  for file; do
    if [[ \$file = *rollouts/*.h5 ]]; then
      id=\$\$
      mv "\$file" "\$tricks/late/\$id.file"
      head -c 100 "\$tricks/late/\$id.file" >"\$file"
      echo "\$PWD/\$file" >"\$tricks/late/\$id.name"
      echo "\$file" >>"\$tricks/hidden"
    fi
  done
fi
exit \$status
STAT
  chmod +x path/stat
  give_back() { # SECONDS
    local name
    while [ -d tricks/late ]; do
      for name in $(find tricks/late -name '*.name' ! -newermt "-$1 seconds"); do mv "${name%.name}.file" "$(<"$name")"; rm "$name"; done
      sleep 0.2
    done
  }
  late() { PATH=$PWD/path:$PATH run_slurm -j4 run SCENE=a/scene.json SPEC=spec.json RUN=run "$@" >log 2>&1; }
  mkdir tricks/late
  give_back 3 3>&- &
  giver=$!
  late || { cat log; return 1; }
  [ "$(wc -l <tricks/hidden)" -eq 2 ]
  same_results local/run run
  rmdir tricks/late
  wait $giver

  # Longer than there is patience.
  rm -rf run
  mkdir tricks/late
  give_back 9 3>&- &
  giver=$!
  refute_late() { if late "$@"; then return 1; fi; cat log; }
  refute_late PATIENCE=2
  grep -qE 'run/simulate-[a-z-]*: error: run/rollouts/[a-z-]*\.h5 was not seen here with its [0-9]+ bytes within 2 s after n[123] wrote it' log
  nothing_left run
  until rmdir tricks/late 2>/dev/null; do sleep 0.2; done
  wait $giver
  late
  same_results local/run run

  # What a node has to read.
  rm -rf run
  touch tricks/blind
  late PATIENCE=2 3>&- &
  make=$!
  for _ in {1..300}; do if grep -q 'lost with n[123]; once more' log; then break; fi; sleep 0.1; done
  cat log
  grep -qE 'n[123]: not all of .*rollouts/.*\.h5.* were seen as they are within 2 s' log
  rm tricks/blind
  wait $make
  same_results local/run run
}

@test "cluster: nodes of different width are named in the records and by the batch" {
  echo 'export PM_KERNELS=sse2' >prolog.n2
  run_slurm -j6 batch SCENES="$scenes" SPEC=spec.json BATCH=batch >log 2>&1
  cat log
  grep -qE 'differ in width \(([a-z0-9]+ on n[13], )*sse2 on n2(, [a-z0-9]+ on n[13])*\): the last digits of their results may differ' log
  [ -n "$(grep -l '^n2 sse2 ' batch/*/.stamps/*.ran)" ]
  # The same kernels for all are one word of make's environment.
  rm -rf batch prolog.n2
  PM_KERNELS=sse2 run_slurm -j6 batch SCENES="$scenes" SPEC=spec.json BATCH=batch >log 2>&1
  refute grep -q 'differ in width' log
  refute grep -qv ' sse2 ' batch/*/.stamps/*.ran
}

@test "cluster: an evaluation has the tables of one machine" {
  mkdir -p suite
  cp "$root/tests/data/tiny.json" suite/good.json
  cat >suite/reference.json <<'JSON'
{"schema": "physmas/configuration/1", "settings": [],
 "rows": {"lollipop/candy": {"branch": "Jelly", "E": 1e5, "nu": 0.4, "rho": 1100}, "lollipop/stick": {"branch": "Metal", "E": 1e6, "nu": 0.3, "rho": 700}},
 "actions": []}
JSON
  cat >suite/suite.json <<'JSON'
{"schema": "physmas/suite/1", "settings": ["render.width=64", "render.height=64", "time.frames=3", "grid.n=24"],
 "methods": [{"id": "full", "name": "Full", "settings": ["screening.initial=2", "screening.rounds=1", "screening.tau=-9"]}],
 "comparison": ["full"], "required": ["trajectory_nrmse"],
 "cases": [{"id": "good", "kind": "multi-part", "example": "good.json", "reference": "reference.json", "objects": ["lollipop"]}]}
JSON
  "$bin/pm-eval" suite --suite suite/suite.json --register
  cp resources table
  for stage in synth reference result; do echo "$stage: 1 core, 300 MiB, 5 min"; done >>table
  run_make evaluate SUITE=suite/suite.json EVALUATE=evaluate >log 2>&1 || { cat log; return 1; }
  mv evaluate local-evaluate
  : >tricks/calls
  run_slurm -j4 evaluate SUITE=suite/suite.json EVALUATE=evaluate RESOURCES=table >log 2>&1 || { cat log; return 1; }
  nothing_left evaluate
  grep -qE '^n[123] pm-simulate .*reference' tricks/calls
  grep -qE '^n[123] pm-eval motion' tricks/calls
  # All but seconds: tables have them.
  without_seconds() { sed -E 's/"seconds": [0-9.e-]+//' "$1/evaluation.json"; }
  grep -q trajectory_nrmse evaluate/evaluation.json
  diff <(without_seconds local-evaluate) <(without_seconds evaluate)
  for folder in local-evaluate evaluate; do rm -r $folder/evaluation.json $folder/results $folder/tables/{cases,table3,times}.* $folder/good/full/inputs; done
  same_results local-evaluate evaluate
  rm -rf local-evaluate evaluate suite
}

@test "cluster: what runs where can be seen" {
  echo 'sleep 3' >tricks/pm-lift.before
  run_slurm -j4 batch SCENES="a/scene.json b/scene.json" SPEC=spec.json BATCH=batch >log 2>&1 3>&- &
  make=$!
  for _ in {1..100}; do [ "$(cat batch/*/.stamps/lift.job.where 2>/dev/null | wc -l)" -lt 2 ] || break; sleep 0.1; done
  run run_make batch-status BATCH=batch
  wait $make
  echo "$output"
  [[ ${lines[0]} = "2 scenes: 0 accepted, 0 with none admitted, 0 failed, 2 to go; 2 jobs run, 0 wait" ]]
  [[ $output =~ a\ +lift\ +n[123]\ +[0-9]+\ s ]]
  run run_make batch-status BATCH=batch EVERY=1
  [[ $output = "2 scenes: 2 accepted, "*"0 to go"* ]]
}
