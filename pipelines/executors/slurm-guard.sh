#!/bin/bash
# slurm-guard.sh WRAPPER START MAKE START PARENT START NOTE: a process of its own beside slurm-job.sh (WRAPPER). When make or the recipe's
# shell (PARENT) is gone it ends the wrapper; when the wrapper is gone before it has cleared up, it takes its note away and cancels the
# job: whatever is killed, no job goes on that nobody waits for.
wrapper=$1 wrapper_start=$2 make=$3 make_start=$4 parent=$5 parent_start=$6 note=$7
source "${BASH_SOURCE[0]%/*}/job-files.sh"
let_go_of_pipes
trap '' INT HUP
while lives "$wrapper" "$wrapper_start"; do
  if ! lives "$make" "$make_start" || ! lives "$parent" "$parent_start"; then kill -TERM "$wrapper" 2>/dev/null; fi
  nap 1
done
mapfile -d '' -t fields < <(cat -- "$note" 2>/dev/null)
if [ "${fields[1]:-}" = "$HOSTNAME $wrapper $wrapper_start" ]; then
  read -r srun srun_start < <(cat -- "$note.srun" 2>/dev/null)
  rm -f -- "$note" "$note".*
  if lives "${srun:-0}" "${srun_start:-}"; then kill -TERM "$srun"; fi
  cancel "${fields[2]}"
  nap 2
  if lives "${srun:-0}" "${srun_start:-}"; then kill -KILL "$srun"; fi
  # The node's last word may have come after all.
  if [ ! -e "$note" ]; then rm -f -- "$note.ended" "$note.where"; fi
fi
exit 0
