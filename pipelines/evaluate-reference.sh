#!/bin/bash
# evaluate-reference.sh SCENE TRUTH CONFIGURATION OUT SETTING...: simulates and renders a reference of the benchmark from its
# hand-authored configuration, with the true labels, in double precision and with steps as small as stability asks. For
# evaluate.mk. Ends with OUT/result.tsv: done, or failed and why; a reference that fails stops nothing else.
set -u
scene=$1 truth=$2 configuration=$3 out=$4
shift 4
settings=()
for setting in "$@"; do settings+=(--set "$setting"); done
inventory=$(dirname "$scene")/inventory.json
mkdir -p "$out"

make_reference() {
  "$BIN/pm-scene" slice --scene "$scene" --out "$out/spec" "${settings[@]}" &&
    "$BIN/pm-lift" --scene "$out/spec/lift.json" --inventory "$inventory" --labels "$truth" --out "$out/state.h5" --threads 1 &&
    "$BIN/pm-candidates" --scene "$out/spec/candidates.json" --inventory "$inventory" --state "$out/state.h5" \
      --configuration "$configuration" --out "$out" &&
    "$BIN/pm-simulate" --scene "$out/spec/simulate.json" --state "$out/state.h5" --candidate "$out/authored.json" \
      --out "$out/rollout.h5" --precision double --timestep cfl --strict --threads 1 &&
    "$BIN/pm-render" --scene "$out/spec/render.json" --state "$out/state.h5" --rollout "$out/rollout.h5" \
      --out "$out/video.mp4" --sheet "$out/video.png" --threads 1
}

if make_reference >"$out/log.txt" 2>&1; then
  echo done >"$out/result.tsv"
else
  printf 'failed\t%s\n' "$(grep 'error:\|diverged' "$out/log.txt" | tail -n 1 | tr '\t' ' ' | cut -c -300)" >"$out/result.tsv"
fi
