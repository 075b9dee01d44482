#!/bin/bash
# slurm-guard.sh WRAPPER START MAKE START PARENT START SRUN NOTE TOKEN NAME: a process of its own beside slurm-job.sh (WRAPPER). When make
# or the recipe's shell (PARENT) is gone it ends the wrapper; when the wrapper is gone before it has cleared up, it takes the note away and
# cancels the job: whatever is killed, no job goes on that nobody waits for.
wrapper=$1 wrapper_start=$2 make=$3 make_start=$4 parent=$5 parent_start=$6 srun=$7 note=$8 token=$9 name=${10}
# Nobody shall wait for this process because it holds the end of a pipe.
for fd in /proc/self/fd/*; do
  fd=${fd##*/}
  if [ "$fd" -gt 2 ] && [ "$fd" -ne 255 ]; then eval "exec $fd>&-"; fi
done
source "$(dirname -- "${BASH_SOURCE[0]}")/job-files.sh"
trap '' INT HUP
while lives "$wrapper" "$wrapper_start"; do
  if ! lives "$make" "$make_start" || ! lives "$parent" "$parent_start"; then kill -TERM "$wrapper" 2>/dev/null; fi
  nap 1
done
if [ "$(token_in "$note")" = "$token" ]; then
  rm -f -- "$note" "$note.ended" "$note.where" "$note.output" "$note.messages"
  if [ "$srun" != - ]; then
    kill -TERM "$srun" 2>/dev/null
    cancel "$name"
    nap 2
    kill -KILL "$srun" 2>/dev/null
  fi
fi
exit 0
