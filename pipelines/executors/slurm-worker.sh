#!/bin/bash
# slurm-worker.sh QUEUE SECONDS: a task of the array job (slurm-workers.sh): takes jobs from the queue, one after the other, until the
# queue is gone or make is, or there is not enough of its SECONDS left for those that wait.
set -u
queue=$1 limit=$2
mine=$1/taken/$SLURM_ARRAY_TASK_ID
scripts=${BASH_SOURCE[0]%/*}
source "$scripts/job-files.sh"
mkdir -p -- "$mine"
# Of a worker that was preempted or whose node was lost.
for entry in "$mine"/*; do
  if [ -e "$entry" ]; then rm -f -- "$entry" && : >"$queue/lost/${entry##*/}"; fi
done
running=
trap 'if [ -n "$running" ]; then kill -TERM "$running"; fi; exit 143' TERM
beat= beaten=$SECONDS
while [ -d "$queue/todo" ]; do
  { read -r now <"$queue/beat"; } 2>/dev/null || now=$beat
  if [ "$now" != "$beat" ]; then beat=$now beaten=$SECONDS; fi
  if [ $((SECONDS - beaten)) -gt 120 ]; then break; fi
  taken= too_long=
  for entry in "$queue"/todo/*; do
    [ -e "$entry" ] || continue
    mapfile -d '' -t fields < <(cat -- "$entry" 2>/dev/null)
    [ ${#fields[@]} -eq 4 ] || continue
    if [[ ${fields[3]} = *,${SLURMD_NODENAME:-},* ]]; then continue; fi
    if [ $((SECONDS + fields[2])) -gt "$limit" ]; then too_long=1; continue; fi
    if mv -- "$entry" "$mine/" 2>/dev/null; then taken=${entry##*/}; break; fi
  done
  if [ -z "$taken" ]; then
    # Too old for what waits: a new one takes its place.
    if [ -n "$too_long" ]; then break; fi
    nap 0.1
    continue
  fi
  bash "$scripts/slurm-node.sh" "${fields[0]}" "${fields[1]}" </dev/null >"${fields[0]}.output" 2>"${fields[0]}.messages" &
  running=$!
  wait "$running"
  running=
  mv -- "$mine/$taken" "$queue/done/$taken" 2>/dev/null
done
exit 0
