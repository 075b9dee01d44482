#!/bin/bash
# slurm-workers.sh QUEUE COUNT MAKE: an array job of COUNT workers (slurm-worker.sh) for the queue of one make, and a process beside it
# that watches: what a worker had that is gone is given back as lost, an array that has ended is started again, and when make is
# gone the workers are cancelled. Prints why, where Slurm does not take it.
#
# QUEUE/todo/ENTRY        a job that waits: fields as slurm-job.sh writes them, ending with NUL
# QUEUE/taken/N/ENTRY     worker N has it
# QUEUE/done/ENTRY        it has ended; QUEUE/lost/ENTRY: its worker has, with what Slurm said
# QUEUE/beat              changes while make lives; QUEUE/watch: the watching process
set -u
queue=$1 count=$2 make=$3
if [[ $queue != /* ]]; then queue=$PWD/$queue; fi
scripts=$(cd -- "${BASH_SOURCE[0]%/*}" && pwd)
source "$scripts/job-files.sh"
source "$scripts/resources.sh"
read -ra resource_files <<<"$PM_RESOURCES"
resources_of worker "${resource_files[@]}" || { printf '%s\n' "$complaint"; exit 1; }

# submit: sets array, the job's id.
submit() {
  local extra=("${options[@]}")
  if [ "$gpus" -gt 0 ]; then extra+=("--gres=gpu:$gpus"); fi
  # A job of its own, also inside of an allocation.
  array=$(unset "${!SLURM_JOB@}" "${!SLURM_STEP@}" "${!SLURM_TASK@}" SLURM_CPUS_PER_TASK SLURM_MEM_PER_NODE SLURM_MEM_PER_CPU MAKEFLAGS MFLAGS MAKELEVEL
    timeout 60 sbatch --parsable --quiet --array="1-$count" --job-name="$(<"$queue/name")" --nodes=1 --ntasks=1 --cpus-per-task="$cores" --mem="${memory}M" \
      --time="$(((seconds + 59) / 60))" --requeue --open-mode=append --output="$queue/worker-%a.log" "${extra[@]}" --wrap "exec bash $(printf '%q %q' "$scripts/slurm-worker.sh" "$queue") $seconds") || return
  array=${array%%;*}
  echo "$array" >"$queue/array"
}

if [ "$count" = watch ]; then
  # In the place of a watch that was killed.
  array=$(<"$queue/array") count=$(<"$queue/count")
else
  if [ -e "$queue/name" ]; then (unset SLURM_JOB_ID; cancel "$(<"$queue/name")"); fi
  rm -rf -- "$queue"
  mkdir -p -- "$queue"/{new,todo,taken,done,lost} || exit 1
  echo "$count" >"$queue/count"
  echo "physmas-workers:$HOSTNAME-$make-$(start_of "$make")" >"$queue/name"
  printf '%s %s %s\n' "$cores" "$memory" "$seconds" >"$queue/worker"
  submit 2>"$queue/refusal" || { cat -- "$queue/refusal"; exit 1; }
fi
make_start=$(start_of "$make")
export make make_start queue count array
(
  trap '' INT HUP TERM
  let_go_of_pipes
  echo "$BASHPID $(start_of "$BASHPID")" >"$queue/watch"
  beat=0
  while lives "$make" "$make_start"; do
    nap 1
    beat=$((beat + 1))
    echo $beat >"$queue/beat"
    if [ $((beat % 5)) -ne 0 ]; then continue; fi
    # Who there is; where Slurm does not say, all. One that was requeued waits again.
    there=$(timeout 20 squeue --noheader --array --jobs "$array" --format '%t %K' 2>/dev/null) || {
      if timeout 20 scontrol ping >/dev/null 2>&1; then there=; else continue; fi
    }
    running=$(sed -n '/^PD /!s/^[^ ]* //p' <<<"$there")
    for worker in "$queue"/taken/*; do
      [ -d "$worker" ] || continue
      if grep -qx -- "${worker##*/}" <<<"$running"; then continue; fi
      for entry in "$worker"/*; do
        [ -e "$entry" ] || continue
        grep -hE '^(srun|slurmstepd[^:]*): ' -- "$queue/worker-${worker##*/}.log" 2>/dev/null | tail -n 5 >"$queue/lost/${entry##*/}.new"
        rm -f -- "$entry"
        mv -- "$queue/lost/${entry##*/}.new" "$queue/lost/${entry##*/}"
      done
    done
    if [ -z "$there" ]; then submit; fi
  done
  (unset SLURM_JOB_ID; cancel "$(<"$queue/name")")
  rm -rf -- "$queue"
) </dev/null >/dev/null 2>&1 &
disown
exit 0
