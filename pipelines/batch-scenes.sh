#!/bin/bash
# batch-scenes.sh LIST SCENES VARIABLES: the scenes of a batch, for batch.mk. SCENES: names of examples, scene.json files and files
# of Gaussians between blanks, or one text file of them; VARIABLES: what may follow a scene in such a file, as NAME=value. Writes
# LIST with a line per scene, tab-separated: the run's name, then the variables that `make run` gets. Prints the names, or in one line why not. A name that
# comes twice is an error, and so is what is neither an example of the folder EXAMPLES nor a file. LIST may be /dev/null, then
# only names are printed.
set -euf
list=$1 asked=$2 variables=$3

refuse() { # WHY
  printf 'batch: %s\n' "$1" | LC_ALL=C tr '\001-\011\013-\037\177' '?'
  exit 1
}

scenes() {
  if [[ $asked = *.txt && -f $asked ]]; then
    sed -e 's/#.*//' -e '/^[[:space:]]*$/d' -- "$asked"
  else
    for scene in $asked; do printf '%s\n' "$scene"; done
  fi
}

# A word behind a scene: make would take anything else than NAME=value for an option, a goal, or an assignment of its own (:=, !=).
require_variable() { # WORD
  local name=${1%%=*}
  [[ $1 = *=* ]] || refuse "$1 behind a scene: expected NAME=value"
  [[ " $variables " = *" $name "* ]] || refuse "a scene has no variable $name: there are $variables"
  case $name in
    AGENT | SCENE_AGENT | PERCEPTION | PREDICTOR)
      [[ $1 != *://*[@?#]* && ($1 = *=replay:* || $1 != *@*) ]] || refuse "$name holds a user name, a password or a query: the key belongs into the environment variable PM_API_KEY"
      ;;
  esac
}

declare -A seen
names=()
lines=
while IFS= read -r line; do
  # xargs splits at blanks outside quotes (as in "it's"), and runs nothing.
  split=$(xargs -n1 printf '%s\n' <<<"$line" 2>/dev/null) || refuse "a quote is not closed: $line"
  mapfile -t words <<<"${split//$'\t'/ }"
  scene=${words[0]}
  case $scene in
    *.json) source=SCENE=$scene; name=$(basename -- "$(realpath -m -- "$(dirname -- "$scene")")") ;;
    *.ply | *.spz | *.splat | *.sog | *.zip | *.gz | *.ksplat) source=GAUSSIANS=$scene; name=$(basename -- "$scene"); name=${name%%.*} ;;
    *)
      if [[ $scene != */* && -e $EXAMPLES$scene.json ]]; then
        source=EXAMPLE=$scene; name=$scene
      elif [ -e "$scene" ]; then
        source=GAUSSIANS=$scene; name=$(basename -- "$scene"); name=${name%%.*}
      else
        refuse "$scene is no example and no file: expected an example's name, a scene.json or a file of Gaussians (.ply, .spz, .splat)"
      fi
      ;;
  esac
  # A bundle of a run is called after the run.
  if [ "$name" = bundle ]; then name=$(basename -- "$(realpath -m -- "$(dirname -- "$scene")/..")"); fi
  # A name is an id, and no file that the batch itself writes: letters, digits, - and _, with dots between.
  name=$(LC_ALL=C sed -E 's/[^A-Za-z0-9_.-]+/-/g; s/^[.-]+//; s/[.-]+$//' <<<"$name")
  name=${name:-scene}
  case $name in table.tsv | table.log | scenes.list | scenes.list.new) name=${name/./-} ;; esac
  if [ -n "${seen[$name]:-}" ]; then refuse "two scenes are called $name"; fi
  seen[$name]=1
  names+=("$name")
  for word in "${words[@]:1}"; do require_variable "$word"; done
  lines+=$(IFS=$'\t'; printf '%s' "$name"$'\t'"$source"$'\t'"${words[*]:1}" | sed 's/\t$//')$'\n'
done < <(scenes)
[ ${#names[@]} -gt 0 ] || refuse 'needs SCENES="name scene.json file.ply ..." or SCENES=list.txt'
if [ "$list" != /dev/null ]; then
  mkdir -p -- "$(dirname -- "$list")"
  printf '%s' "$lines" >"$list.new"
  mv -- "$list.new" "$list"
fi
echo "${names[@]}"
