#!/bin/bash
# batch-begin.sh BATCH: makes the folders of the scenes that there is something to do for (BATCH/.live/to-do), and forgets how they
# ended before.
set -eu
sweep=$(realpath -- "${BASH_SOURCE[0]%/*}/sweep.sh")
cd -- "$1"
rm -rf .live/running
mkdir -p .live/running
printf '%(%s)T\n' -1 >.live/begun
mapfile -t names <.live/to-do
if [ -z "${names[*]}" ]; then exit 0; fi
printf '%s/.stamps\0' "${names[@]}" | xargs -0 mkdir -p --
for name in "${names[@]}"; do printf '%s\0' "$name"/batch.status "$name"/.stamps/{settled,begun}; done | xargs -0 rm -f --
for name in "${names[@]}"; do : >"$name/log.txt"; done
printf '%s\0' "${names[@]}" | xargs -0 bash "$sweep"
