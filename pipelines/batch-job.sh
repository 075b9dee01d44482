#!/bin/bash
# batch-job.sh BATCH RUN JOB COMMAND...: a job of a scene of a batch. What it prints is in the scene's log; that it runs, and how long it
# took, is in BATCH/.live for batch-status.sh. Where it fails, so has the scene.
set -u
source "${BASH_SOURCE[0]%/*}/wait-for.sh"
batch=$1 run=$2 job=$3
shift 3
live=$batch/.live mark=$batch/.live/running/${run##*/}@$job
began=$EPOCHREALTIME
if [ ! -e "$run/.stamps/begun" ]; then echo "$began" >"$run/.stamps/begun"; fi
printf '%s %s %s\n' "$began" "${HOSTNAME:-}" $$ >"$mark"
# Whatever would end this process ends the command.
"$@" >>"$run/log.txt" 2>&1 &
command=$!
trap 'kill -TERM $command 2>/dev/null' INT TERM HUP
wait_for $command
rm -f -- "$mark"
# Seconds with three decimals since a time with six.
since() { local span=$((${EPOCHREALTIME/[.,]/} - ${1/[.,]/})); printf '%d.%03d' $((span / 1000000)) $((span / 1000 % 1000)); }
if [ $status -eq 0 ] || [ $status -eq 6 ]; then
  printf '%s %s\n' "${job%%[-0-9]*}" $(since "$began") >>"$live/times"
elif [ $status -lt 128 ] || [ $status -eq 132 ] || [ $status -eq 137 ]; then
  if [ ! -e "$run/batch.status" ]; then printf '  %-13s  %s\n' failed "$run"; fi
  echo "$status $(since "$(<"$run/.stamps/begun")")" >"$run/batch.status"
fi
exit $status
