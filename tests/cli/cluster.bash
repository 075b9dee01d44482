# A real Slurm of three virtual nodes on this machine (tests/cluster/slurm.sh), for the tests of the executor `slurm`.

# For setup_file and teardown_file. A second partition, urgent, takes the nodes from the first, and gives at most an hour; what `prolog`
# prints on a node is Slurm's, `export NAME=value` for the node's tasks.
start_cluster() {
  if ! command -v srun >/dev/null || ! PATH=$PATH:/usr/sbin command -v slurmctld >/dev/null; then
    echo "the executor slurm is tested with a real Slurm: apt-get install slurm-wlm munge" >&2
    return 1
  fi
  printf '#!/bin/bash\ncat "%s/prolog.$SLURMD_NODENAME" 2>/dev/null\nexit 0\n' "$BATS_FILE_TMPDIR" >"$BATS_FILE_TMPDIR/prolog"
  chmod +x "$BATS_FILE_TMPDIR/prolog"
  "$root/tests/cluster/slurm.sh" start "$BATS_FILE_TMPDIR/slurm" 3 2 PreemptType=preempt/partition_prio PreemptMode=REQUEUE \
    "PartitionName=urgent Nodes=ALL PriorityTier=10 MaxTime=60" "TaskProlog=$BATS_FILE_TMPDIR/prolog" 3>&-
  export SLURM_CONF=$BATS_FILE_TMPDIR/slurm/slurm.conf
}
stop_cluster() { "$root/tests/cluster/slurm.sh" stop "$BATS_FILE_TMPDIR/slurm"; }
slurm() { "$root/tests/cluster/slurm.sh" "$1" "$BATS_FILE_TMPDIR/slurm" "${@:2}" 3>&-; }

# Scenes of a few hundred Gaussians, and what their jobs need.
make_scenes() { # NAME...
  local name stage
  for name; do "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out "$name" --quiet; done
  cat >spec.json <<'J'
{"schema": "physmas/run/1", "grid": {"n": 24}, "time": {"frames": 4, "substep_dt": 8e-4, "min_substep_dt": 2e-4, "max_substeps": 200},
 "screening": {"initial": 2, "rounds": 1, "tau": -9}, "render": {"width": 64, "height": 64}}
J
  for stage in default bundle ground lift material simulate camera render best; do echo "$stage: 1 core, 300 MiB, 2 min"; done >resources
  echo 'worker: 1 core, 300 MiB, 10 min' >>resources
}

# Tools that do what a file of the folder `tricks` says before or after the real ones: TOOL.before, any.before, any.after.
make_tricky_tools() {
  mkdir tools tricks
  local tool name
  for tool in "$bin"/pm-*; do
    name=${tool##*/}
    cat >"tools/$name" <<TOOL
#!/bin/bash
tricks=$(printf %q "$PWD/tricks") node=\${SLURMD_NODENAME:-here}
echo "\$node $name \$*" >>"\$tricks/calls"
if [ -e "\$tricks/$name.before" ]; then source "\$tricks/$name.before"; fi
if [ -e "\$tricks/any.before" ]; then source "\$tricks/any.before"; fi
$(printf %q "$tool") "\$@"
status=\$?
if [ -e "\$tricks/any.after" ]; then source "\$tricks/any.after"; fi
exit \$status
TOOL
    chmod +x "tools/$name"
  done
}

# make with the tools of the folder, by the executor slurm or another one.
run_make() {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$PWD/tools" THREADS=1 "$@"
}
run_slurm() { run_make EXECUTOR=slurm RESOURCES=resources PATIENCE=10 "$@"; }

# What differs between two runs or batches beside what a batch notes about itself.
same_results() { # A B
  local differences
  [ -e "$1" ] || return 1
  [ -e "$2" ] || return 1
  differences=$(python3 "$root/tests/tools/compare_runs.py" "$1" "$2" | sed -E '/(table\.tsv|log\.txt|batch\.status|\.live\/.*)$/d')
  echo "$differences"
  [ -z "$differences" ]
}

# Nothing of a make that has ended is in the queue, on a node, or among the notes.
nothing_left() { # FOLDER
  local tries
  for tries in {1..100}; do
    if [ -z "$(squeue --noheader 2>&1)" ] && [ -z "$(processes_on_nodes)" ] && [ -z "$(find "$1" -name '*.job*' -o -name .queue)" ]; then return 0; fi
    sleep 0.2
  done
  squeue
  processes_on_nodes
  find "$1" -name '*.job*' -o -name .queue
  return 1
}
# Of this Slurm's steps.
processes_on_nodes() {
  local environ
  for environ in $(grep -lzxF -e "SLURM_CONF=$SLURM_CONF" /proc/[0-9]*/environ 2>/dev/null); do
    if grep -zq '^SLURM_STEP_ID=' "$environ" 2>/dev/null; then
      tr '\0' ' ' <"${environ%environ}cmdline"
      echo
    fi
  done
}
