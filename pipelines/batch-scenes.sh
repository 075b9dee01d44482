#!/bin/bash
# batch-scenes.sh LIST SCENE...: the scenes of a batch, for batch.mk. Writes LIST with a line per scene, tab-separated: the
# run's name, then the variables that `make run` gets. Prints the names. A name that comes twice is an error.
set -eu
list=$1
shift
mkdir -p "$(dirname "$list")"

scenes() {
  if [ $# -eq 1 ] && [[ $1 = *.txt ]]; then
    sed -e 's/#.*//' -e '/^[[:space:]]*$/d' "$1"
  else
    for scene in "$@"; do printf '%s\n' "$scene"; done
  fi
}

declare -A seen
names=()
: >"$list.new"
while IFS= read -r line; do
  # xargs splits at blanks outside quotes (as in "it's"), and runs nothing.
  split=$(xargs -n1 printf '%s\n' <<<"$line" 2>/dev/null) || { echo "batch: a quote is not closed: $line" >&2; exit 1; }
  mapfile -t words <<<"$split"
  scene=${words[0]}
  case $scene in
    *.json) source=SCENE=$scene; name=$(basename "$(dirname "$scene")") ;;
    *.ply | *.splat) source=GAUSSIANS=$scene; name=$(basename "$scene"); name=${name%%.*} ;;
    *) source=EXAMPLE=$scene; name=$scene ;;
  esac
  # A bundle of a run is called after the run.
  if [ "$name" = bundle ]; then name=$(basename "$(dirname "$(dirname "$scene")")"); fi
  name=$(tr -c 'A-Za-z0-9_.\n-' - <<<"$name")
  if [ -n "${seen[$name]:-}" ]; then
    echo "batch: two scenes are called $name" >&2
    exit 1
  fi
  seen[$name]=1
  names+=("$name")
  (IFS=$'\t'; printf '%s\n' "$name"$'\t'"$source"$'\t'"${words[*]:1}") | sed 's/\t$//' >>"$list.new"
done < <(scenes "$@")
[ ${#names[@]} -gt 0 ]
mv "$list.new" "$list"
echo "${names[@]}"
