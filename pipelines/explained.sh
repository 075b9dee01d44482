#!/bin/bash
# explained.sh RUN STAGE BIN -- COMMAND...: runs the command of a stage. Where it fails, the run's page says which stage and why. Ends as
# the command does; PM_FINE is a status that is no failure either. What would end this process ends the command.
source "${BASH_SOURCE[0]%/*}/wait-for.sh"
run=$1 stage=$2 bin=$3
shift 4
"$@" &
command=$!
trap 'kill -TERM $command 2>/dev/null' INT TERM HUP
wait_for $command
case $status in
  0 | "${PM_FINE:-0}" | 129 | 130 | 143) exit $status ;;
esac
rm -f -- "$run/.stamps/report"
if PM_STAGE='' "$bin/pm-report" --run "$run" --failed "$stage" --status $status --threads 1 >/dev/null 2>&1; then
  echo "$run/report.html says what failed and what to do" >&2
fi
exit $status
