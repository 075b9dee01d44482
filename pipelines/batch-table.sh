#!/bin/bash
# batch-table.sh BATCH: the table of a batch, and its page. A scene of this call that did not come to its end has failed.
set -u
batch=$1
mapfile -t to_do <"$batch/.live/to-do"
for name in ${to_do[@]+"${to_do[@]}"}; do
  if [ -n "$name" ] && [ ! -e "$batch/$name/batch.status" ]; then
    echo "2 0" >"$batch/$name/batch.status"
    printf '  %-13s  %s\n' failed "$batch/$name"
  fi
done
# A table of the same scenes, of which none was run, is there already.
if [ -z "${to_do[*]-}" ] && [ -e "$batch/table.tsv" ] && [ -e "$batch/index.html" ] && cmp -s "$batch/.live/scenes" "$batch/.live/in-table"; then exit 0; fi
rm -f -- "$batch/.live/in-table"
mapfile -t names <"$batch/.live/scenes"
"$BIN/pm-screen" --table "${names[@]/#/$batch/}" --out "$batch/table.tsv" || exit
"$BIN/pm-report" index "${names[@]/#/$batch/}" --out "$batch/index.html" || exit
# Kernels of different width round differently (docs/install.md).
widths=$(find "$batch" -mindepth 3 -maxdepth 3 -path '*/.stamps/*.ran' -name '[sr]*' -exec cat -- {} + | awk 'NF >= 2 { print $2 " on " $1 }' | sort -u)
if [ "$(cut -d' ' -f1 <<<"$widths" | sort -u | wc -l)" -gt 1 ]; then
  echo "The nodes' processors differ in width ($(paste -sd, <<<"$widths" | sed 's/,/, /g')): the last digits of their results may differ; PM_KERNELS=avx2 with tools of ARCH=baseline makes them equal" >&2
fi
cp -- "$batch/.live/scenes" "$batch/.live/in-table"
exit 0
