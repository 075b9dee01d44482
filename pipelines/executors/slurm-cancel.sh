#!/bin/bash
# slurm-cancel.sh NAME: cancels the job, or the step of this allocation, that is called so, and does not rest before Slurm says that there is
# none: slurmctld may be away, or may only just be about to start what a process that has been killed asked for. At most half an hour.
set -u
name=$1
source "${BASH_SOURCE[0]%/*}/job-files.sh"
let_go_of_pipes
trap '' INT HUP
gone=0
until [ $gone -ge 3 ] || [ $SECONDS -gt 1800 ] || no_slurm; do
  if [ -n "${SLURM_JOB_ID:-}" ]; then
    # An allocation that has ended has no steps.
    list=$(timeout 20 squeue --steps --noheader --job "$SLURM_JOB_ID" --format '%i|%j' 2>&1) || { case $list in *"Invalid job id"*) exit 0 ;; esac; list=unknown; }
  else
    list=$(timeout 20 squeue --noheader --name "$name" --format '%i|%j' 2>/dev/null) || list=unknown
  fi
  if [ "$list" = unknown ]; then
    gone=0
  elif ids=$(awk -F '|' -v name="$name" '$2 == name { print $1 }' <<<"$list") && [ -n "$ids" ]; then
    gone=0
    # shellcheck disable=SC2086
    timeout 20 scancel --quiet $ids
  else
    gone=$((gone + 1))
  fi
  nap $((gone > 0 ? gone : 1))
done
exit 0
