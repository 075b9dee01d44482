#!/bin/bash
# slurm-watch.sh MAKE: a process beside make that looks every ten seconds whether Slurm has jobs (in an allocation, steps) that a slurm-job.sh of
# this machine asked for which is gone, and cancels them: a slurmctld that was killed takes jobs that had ended for running ones, which
# would keep their cores. It ends some time after make, when it has seen none three times.
set -u
make=$1
source "${BASH_SOURCE[0]%/*}/job-files.sh"
let_go_of_pipes
trap '' INT HUP
make_start=$(start_of "$make")
clean=0 ended=
# Where Slurm does not answer any more, ten minutes.
while ! no_slurm; do
  if lives "$make" "$make_start"; then
    nap 10
  else
    ended=${ended:-$SECONDS}
    if [ $clean -ge 3 ] || [ $((SECONDS - ended)) -gt 600 ]; then break; fi
    nap 3
  fi
  if [ -n "${SLURM_JOB_ID:-}" ]; then
    list=$(timeout 20 squeue --steps --noheader --job "$SLURM_JOB_ID" --format '%i|%j' 2>&1) || { case $list in *"Invalid job id"*) exit 0 ;; esac; clean=0; continue; }
  else
    list=$(timeout 20 squeue --noheader --user "$(id -un)" --format '%i|%j' 2>/dev/null) || { clean=0; continue; }
  fi
  orphans=()
  while IFS='|' read -r id name; do
    # RUN/JOB:HOST-PROCESS-START-TRY-NUMBER, as slurm-job.sh calls it.
    token=${name##*:}
    rest=${token%-*-*}
    start=${rest##*-} rest=${rest%-*}
    process=${rest##*-} host=${rest%-*}
    if [ "$host" = "$HOSTNAME" ] && [[ $process =~ ^[0-9]+$ && $start =~ ^[0-9]+$ ]] && ! lives "$process" "$start"; then orphans+=("$id"); fi
  done <<<"$list"
  clean=$((clean + 1))
  if [ ${#orphans[@]} -gt 0 ]; then
    clean=0
    timeout 20 scancel --quiet "${orphans[@]}"
  fi
done
exit 0
