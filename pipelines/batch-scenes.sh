#!/bin/bash
# batch-scenes.sh LIST SCENES VARIABLES: the scenes of a batch, for batch.mk. SCENES: names of examples, scene.json files and files
# of Gaussians between blanks, or one text file of them; VARIABLES: what may follow a scene in such a file, as NAME=value. Writes
# LIST with a line per scene, tab-separated: the run's name, then the variables that it gets. Prints the names, or in one line why not. A name that
# comes twice is an error, and so is what is neither an example of the folder EXAMPLES nor a file. LIST may be /dev/null, then
# only names are printed.
set -euf
shopt -s extglob
# No process for a scene: there may be thousands.
LC_ALL=C
list=$1 asked=$2 variables=$3

refuse() { # WHY
  printf 'batch: %s\n' "$1" | tr '\001-\011\013-\037\177' '?'
  exit 1
}

scenes() {
  if [[ $asked = *.txt && -f $asked ]]; then
    sed -e 's/#.*//' -e '/^[[:space:]]*$/d' -- "$asked"
  else
    for scene in $asked; do printf '%s\n' "$scene"; done
  fi
}

# split LINE: its words, at blanks outside quotes, as xargs does it.
split() {
  local rest=$1 word='' inside=
  words=()
  while [ -n "$rest" ]; do
    case $rest in
      [[:space:]]*)
        if [ -n "$inside" ]; then words+=("$word"); fi
        word='' inside= rest=${rest##+([[:space:]])}
        ;;
      \"*\"*) rest=${rest#\"} word+=${rest%%\"*} rest=${rest#*\"} inside=1 ;;
      \'*\'*) rest=${rest#\'} word+=${rest%%\'*} rest=${rest#*\'} inside=1 ;;
      [\"\']*) refuse "a quote is not closed: $1" ;;
      \\*) word+=${rest:1:1} rest=${rest:2} inside=1 ;;
      *)
        local plain=${rest%%[[:space:]\"\'\\]*}
        word+=$plain rest=${rest:${#plain}} inside=1
        ;;
    esac
  done
  if [ -n "$inside" ]; then words+=("$word"); fi
}

# A word behind a scene: make would take anything else than NAME=value for an option, a goal, or an assignment of its own (:=, !=).
require_variable() { # WORD
  local name=${1%%=*}
  [[ $1 = *=* ]] || refuse "$1 behind a scene: expected NAME=value"
  [[ " $variables " = *" $name "* ]] || refuse "a scene has no variable $name: there are $variables"
  case $name in
    AGENT | SCENE_AGENT | PERCEPTION | PREDICTOR)
      [[ $1 != *://*[@#]* && ($1 = *=replay:* || $1 != *@*) && -z $(bash "$(dirname -- "$0")/url-credentials.sh" "$1") ]] ||
        refuse "$name holds a user name, a password, or what may be one in its query: the key belongs into the environment variable PM_API_KEY, or into HEADERS=file"
      ;;
  esac
}

# without_ending FILE: of its name, what stands before the first dot.
without_ending() { name=${1##*/} name=${name%%.*}; }

names=() lines=() folders=()
while IFS= read -r line; do
  split "${line//$'\t'/ }"
  scene=${words[0]} folder=.
  case $scene in
    # The folder's own name, wherever links and dots lead.
    *.json) source=SCENE=$scene name=; if [[ $scene = */* ]]; then folder=${scene%/*}/; fi ;;
    *.ply | *.spz | *.splat | *.sog | *.zip | *.gz | *.ksplat) source=GAUSSIANS=$scene; without_ending "$scene" ;;
    *)
      if [[ $scene != */* && -e $EXAMPLES$scene.json ]]; then
        source=EXAMPLE=$scene name=$scene
      elif [ -e "$scene" ]; then
        source=GAUSSIANS=$scene; without_ending "$scene"
      else
        refuse "$scene is no example and no file: expected an example's name, a scene.json or a file of Gaussians (.ply, .spz, .splat)"
      fi
      ;;
  esac
  names+=("$name") folders+=("$folder")
  line=$source
  for word in "${words[@]:1}"; do
    require_variable "$word"
    line+=$'\t'$word
  done
  lines+=("$line")
done < <(scenes)
[ ${#names[@]} -gt 0 ] || refuse 'needs SCENES="name scene.json file.ply ..." or SCENES=list.txt'

mapfile -d '' -t whole < <(printf '%s\0' "${folders[@]}" | xargs -0 realpath -mz --)
declare -A seen
for i in "${!names[@]}"; do
  name=${names[i]}
  if [[ ${lines[i]} = SCENE=* ]]; then
    at=${whole[i]}
    # A bundle of a run is called after the run.
    if [ "${at##*/}" = bundle ]; then at=${at%/*}; fi
    name=${at##*/}
  fi
  # A name is an id, and no file that the batch itself writes: letters, digits, - and _, with dots between.
  name=${name//+([^A-Za-z0-9_.-])/-} name=${name##+([.-])} name=${name%%+([.-])}
  name=${name:-scene}
  case $name in table.tsv | table.log | scenes.list | scenes.list.new) name=${name/./-} ;; esac
  if [ -n "${seen[$name]:-}" ]; then refuse "two scenes are called $name"; fi
  seen[$name]=1 names[i]=$name
done
if [ "$list" != /dev/null ]; then
  if [[ $list = */* ]]; then mkdir -p -- "${list%/*}"; fi
  for i in "${!names[@]}"; do printf '%s\t%s\n' "${names[i]}" "${lines[i]}"; done >"$list.new"
  mv -- "$list.new" "$list"
fi
echo "${names[@]}"
