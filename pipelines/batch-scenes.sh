#!/bin/bash
# batch-scenes.sh LIST SCENE...: the scenes of a batch, for batch.mk. Writes LIST with a line per scene, tab-separated: the
# run's name, then the variables that `make run` gets. Prints the names. A name that comes twice is an error, and so is what
# is neither an example of the folder EXAMPLES nor a file. LIST may be /dev/null, then only names are printed.
set -eu
list=$1
shift
if [ "$list" != /dev/null ]; then mkdir -p "$(dirname "$list")"; fi

scenes() {
  if [ $# -eq 1 ] && [[ $1 = *.txt ]]; then
    sed -e 's/#.*//' -e '/^[[:space:]]*$/d' "$1"
  else
    for scene in "$@"; do printf '%s\n' "$scene"; done
  fi
}

declare -A seen
names=()
lines=
while IFS= read -r line; do
  # xargs splits at blanks outside quotes (as in "it's"), and runs nothing.
  split=$(xargs -n1 printf '%s\n' <<<"$line" 2>/dev/null) || { echo "batch: a quote is not closed: $line" >&2; exit 1; }
  mapfile -t words <<<"$split"
  scene=${words[0]}
  case $scene in
    *.json) source=SCENE=$scene; name=$(basename "$(dirname "$scene")") ;;
    *.ply | *.spz | *.splat | *.sog | *.zip | *.gz | *.ksplat) source=GAUSSIANS=$scene; name=$(basename "$scene"); name=${name%%.*} ;;
    *)
      if [[ $scene != */* && -e $EXAMPLES$scene.json ]]; then
        source=EXAMPLE=$scene; name=$scene
      elif [ -e "$scene" ]; then
        source=GAUSSIANS=$scene; name=$(basename "$scene"); name=${name%%.*}
      else
        echo "batch: $scene is no example and no file: expected an example's name, a scene.json or a file of Gaussians (.ply, .spz, .splat)" >&2
        exit 1
      fi
      ;;
  esac
  # A bundle of a run is called after the run.
  if [ "$name" = bundle ]; then name=$(basename "$(dirname "$(dirname "$scene")")"); fi
  name=$(LC_ALL=C sed -E 's/[^A-Za-z0-9_.-]+/-/g; s/^-+//; s/-+$//' <<<"$name")
  name=${name:-scene}
  if [ -n "${seen[$name]:-}" ]; then
    echo "batch: two scenes are called $name" >&2
    exit 1
  fi
  seen[$name]=1
  names+=("$name")
  lines+=$(IFS=$'\t'; printf '%s' "$name"$'\t'"$source"$'\t'"${words[*]:1}" | sed 's/\t$//')$'\n'
done < <(scenes "$@")
[ ${#names[@]} -gt 0 ]
if [ "$list" != /dev/null ]; then
  printf '%s' "$lines" >"$list.new"
  mv "$list.new" "$list"
fi
echo "${names[@]}"
