#!/usr/bin/env bash
# record-seeds.sh BIN CORPUS: runs the tiny scene through the tools and keeps its records as seeds of the target `records`.
set -euo pipefail
bin=$(realpath "$1") corpus=$(realpath "$2") root=$(realpath "$(dirname "$0")/../..")
run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT
cd "$run"
"$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle
"$bin/pm-ground" --scene bundle/scene.json --out .
"$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out state.h5
"$bin/pm-material" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json
"$bin/pm-candidates" --scene bundle/scene.json --inventory inventory.json --plan plan.json --evidence evidence.json \
  --state state.h5 --out candidates
candidate=$(ls candidates | grep -v round | head -1)
"$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate "candidates/$candidate" --out rollout.h5
"$bin/pm-render" --scene bundle/scene.json --state state.h5 --rollout rollout.h5 --out video.mp4
cp plan.json "$corpus/plan"
cp evidence.json "$corpus/evidence"
cp "candidates/$candidate" "$corpus/candidate"
cp candidates/round0.json "$corpus/round"
cp rollout.json "$corpus/execution"
cp video.json "$corpus/render"
cp "$root/tests/data/tiny.json" "$corpus/example"
sed 's|cake/sponge|lollipop/candy|' "$root/tests/data/stages/material-records.json" > "$corpus/material_records"
