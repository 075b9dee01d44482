#!/bin/bash
# batch-refuse.sh BATCH RUN WHY: a scene of a batch cannot run.
printf '%s: error: %s\n' "$2" "$3" >>"$2/log.txt"
echo "2 0" >"$2/batch.status"
printf '  %-13s  %s\n' failed "$2" >&2
