#!/bin/bash
# mask-study.sh FOLDER [EXAMPLE...]: how much of the labels is left where masks are not what they should be. Prints a table in Markdown:
# row accuracy over all Gaussians for true masks and for each way of spoiling them (tests/tools/spoil_masks.cpp). PM_BIN is the
# folder of the tools.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
bin=$(realpath "${PM_BIN:-$here/build/bin}")
spoil=${PM_TEST_BIN:-$bin/../test}/spoil_masks
folder=$1
shift
[ $# -gt 0 ] || set -- cake hammer-cake sunflower pineapple ball-glass
kinds=("true" "holes 0.15" "holes 0.4" "bleed 1" "bleed 3" "shrink 1" "missing 1" "missing 2" "swapped 1" "swapped 2" "medium 1")

accuracy() { # SCENE MASKS OUT
  "$bin/pm-ground" --scene "$1" --out "$3" --perception "masks:$2" --threads "${THREADS:-1}" 2>"$3.log"
  "$bin/pm-lift" --scene "$1" --inventory "$3/inventory.json" --masks "$3/masks.h5" --out "$3/state.h5" --threads "${THREADS:-1}" 2>>"$3.log"
  "$bin/pm-eval" labels --scene "$1" --inventory "$3/inventory.json" --state "$3/state.h5" --out "$3/labels.json" >"$3.table"
  python3 -c 'import json, sys; print("%.3f" % json.load(open(sys.argv[1]))["row_accuracy"])' "$3/labels.json"
}

mkdir -p "$folder"
printf '| masks |'
printf ' %s |' "$@"
printf '\n|---|'
for _ in "$@"; do printf -- '---|'; done
echo
for example in "$@"; do
  [ -e "$folder/$example/scene.json" ] || "$bin/pm-scene" synth "$here/examples/$example.json" --out "$folder/$example" --true-masks --quiet --threads "${THREADS:-1}"
done
for kind in "${kinds[@]}"; do
  printf '| %s |' "$kind"
  for example in "$@"; do
    masks=$folder/$example/true-masks
    out=$folder/$example-${kind// /-}
    if [ "$kind" != true ]; then
      rm -rf "$out.masks"
      # shellcheck disable=SC2086
      "$spoil" "$masks" "$out.masks" $kind
      masks=$out.masks
    fi
    printf ' %s |' "$(accuracy "$folder/$example/scene.json" "$masks" "$out")"
  done
  echo
done
