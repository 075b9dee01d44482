# The table of resources (resources.txt), for the executor slurm. Sourced.

# resources_of STAGE FILE...: sets here (1 or empty), cores, memory (MiB), seconds, gpus, options (an array) and resources_at (FILE:LINE) from the
# last line that names the stage, else from that of `default`. Fails with a message in `complaint` where such a line cannot be read.
resources_of() {
  local stage=$1 file line number=0 found= found_at= fallback= fallback_at=
  shift
  for file; do
    number=0
    while IFS= read -r line || [ -n "$line" ]; do
      number=$((number + 1))
      line=${line%%#*}
      case $line in
        "$stage":*) found=${line#*:} found_at=$file:$number ;;
        default:*) fallback=${line#*:} fallback_at=$file:$number ;;
      esac
    done <"$file"
  done
  if [ -z "$found_at" ]; then found=$fallback found_at=$fallback_at; fi
  resources_at=$found_at
  read_resources "$found" || { complaint="$found_at: $complaint"; return 1; }
}

# read_resources TEXT: of one line, what stands behind the stage.
read_resources() {
  local fields field
  here= cores= memory= seconds= gpus=0 options=() complaint=
  IFS=, read -ra fields <<<"$1"
  for field in "${fields[@]}"; do
    field=${field#"${field%%[![:space:]]*}"} field=${field%"${field##*[![:space:]]}"}
    if [[ $field =~ ^([1-9][0-9]{0,4})\ +cores?$ ]]; then cores=${BASH_REMATCH[1]}
    elif [[ $field =~ ^([1-9][0-9]{0,6})\ +MiB$ ]]; then memory=${BASH_REMATCH[1]}
    elif [[ $field =~ ^([1-9][0-9]{0,4})\ +GiB$ ]]; then memory=$((BASH_REMATCH[1] * 1024))
    elif [[ $field =~ ^([1-9][0-9]{0,6})\ +s$ ]]; then seconds=${BASH_REMATCH[1]}
    elif [[ $field =~ ^([1-9][0-9]{0,5})\ +min$ ]]; then seconds=$((BASH_REMATCH[1] * 60))
    elif [[ $field =~ ^([1-9][0-9]{0,3})\ +h$ ]]; then seconds=$((BASH_REMATCH[1] * 3600))
    elif [[ $field =~ ^([1-9][0-9]{0,2})\ +gpus?$ ]]; then gpus=${BASH_REMATCH[1]}
    elif [[ $field =~ ^--[a-z-]+(=[A-Za-z0-9_.:/@%+-]+)?$ ]]; then options+=("$field")
    elif [ "$field" = here ]; then here=1
    else complaint="found \"$field\", expected N cores, N MiB or N GiB, N s or N min or N h, N gpu, --option=value of srun, or here"; return 1
    fi
  done
  if [ -n "$here" ]; then
    [ ${#fields[@]} -eq 1 ] || { complaint="found \"here\" beside other words"; return 1; }
  elif [ -z "$cores" ] || [ -z "$memory" ] || [ -z "$seconds" ]; then
    complaint="found \"${1# }\", expected cores, memory and time: 8 cores, 2 GiB, 20 min"
    return 1
  fi
}

# all_resources FILE...: prints STAGE=CORES for every stage that a line names, one word each, or STAGE=here; or fails with the complaint.
all_resources() {
  local file line stage number words=
  declare -A stages=()
  for file; do
    number=0
    while IFS= read -r line || [ -n "$line" ]; do
      number=$((number + 1))
      line=${line%%#*}
      if [[ $line =~ ^[[:space:]]*$ ]]; then continue; fi
      if [[ ! $line =~ ^([a-z]+): ]]; then complaint="$file:$number: found \"$line\", expected STAGE: N cores, N GiB, N min"; return 1; fi
      stages[${BASH_REMATCH[1]}]=1
    done <"$file"
  done
  for stage in "${!stages[@]}"; do
    resources_of "$stage" "$@" || return 1
    words+=" $stage=${here:+here}${cores}"
  done
  echo "$words"
}
