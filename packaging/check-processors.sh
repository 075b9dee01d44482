#!/bin/bash
# Runs a baseline build, and its unit tests of what has kernels, with every set that this processor has, and the build on emulated
# older processors.
#   check-processors.sh BUILD EXAMPLE.json
set -eu
build=$(realpath "$1") example=$(realpath "$2")
bin=$build/bin
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$bin/pm-scene" synth "$example" --out bundle --quiet
"$bin/pm-ground" --scene bundle/scene.json --out . --quiet
"$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out state.h5 --quiet
"$bin/pm-material" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json --quiet
"$bin/pm-candidates" --scene bundle/scene.json --inventory inventory.json --plan plan.json --evidence evidence.json --state state.h5 \
  --out candidates --quiet
candidate=$(basename "$(find candidates -name '*.json' ! -name 'round*' | sort | head -n 1)" .json)

# $1: a name; the rest: what runs the tools.
simulate_and_render() {
  local name=$1
  shift
  "$@" "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate "candidates/$candidate.json" --out "$name/$candidate.h5" \
    --frames 10 --strict --quiet
  "$@" "$bin/pm-render" --scene bundle/scene.json --state state.h5 --rollout "$name/$candidate.h5" --out "$name/$candidate.mp4" --frames 0,9 --quiet
  echo "$name: simulated and rendered"
}

"$bin/pm-simulate" --version
status=0
PM_KERNELS=mmx "$bin/pm-scene" info bundle/scene.json >/dev/null 2>refused || status=$?
[ $status -eq 2 ] || { echo "PM_KERNELS=mmx: exit code $status, expected 2"; exit 1; }
for set in sse2 avx2 avx512; do
  if PM_KERNELS=$set "$bin/pm-scene" info bundle/scene.json >/dev/null 2>&1; then
    PM_KERNELS=$set "$build/test/unit" --source-file='*unit/mpm/*,*unit/splat/*' --minimal
    simulate_and_render $set env PM_KERNELS=$set
  else
    echo "$set: this processor does not have it"
  fi
done
emulator=$(command -v qemu-x86_64-static || command -v qemu-x86_64 || true)
if [ -z "$emulator" ] || [ "$(uname -m)" != x86_64 ]; then
  echo "older processors: not emulated, there is no qemu-x86_64 (qemu-user-static)"
  exit
fi
for cpu in Nehalem Haswell; do
  "$emulator" -cpu $cpu "$bin/pm-simulate" --version 2>/dev/null
  simulate_and_render $cpu "$emulator" -cpu $cpu 2> >(grep -v 'TCG doesn' >&2)
done
