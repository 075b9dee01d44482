#!/bin/bash
# slurm-job.sh NAME STAGE INPUTS OUTPUTS LOG MAKE -- COMMAND...: runs a job of a recipe on a cluster (slurm.mk), and returns with the
# command's status when its outputs are seen here. Jobs that their node, the network or Slurm lost are started again; those that
# were cancelled or went beyond their time or memory are not, but for PM_RETRY. Ended by a signal, it cancels the job.
set -u
job=$1 stage=$2 make=$6
read -ra inputs <<<"$3"
read -ra outputs <<<"$4"
stamp=${5%.log}
shift 7
scripts=${BASH_SOURCE[0]%/*}
source "$scripts/job-files.sh"
source "$scripts/resources.sh"
patience=${PM_PATIENCE:-60}

read -ra resource_files <<<"$PM_RESOURCES"
resources_of "$stage" "${resource_files[@]}" || { printf '%s\n' "$complaint" >&2; exit 2; }
case " $* " in *" --device cuda "* | *" --device=cuda "*) if [ "$gpus" -eq 0 ]; then gpus=1; fi ;; esac

# --- What it reads --------------------------------------------------------------------------------------------------

files=() seen=()
for input in "${inputs[@]}"; do
  if [ -f "$input" ]; then files+=("$input"); fi
done
if [ ${#files[@]} -gt 0 ]; then mapfile -t seen < <(stat -Lc '%s %.9Y %n' -- "${files[@]}"); fi

# remember_inputs SHA256...: of the files, for slurm-before.sh.
remember_inputs() {
  local sums=("$@") i
  if [[ $stamp != */.stamps/* ]] || [ ${#sums[@]} -ne ${#seen[@]} ]; then return; fi
  for i in "${!sums[@]}"; do printf '%s %s\n' "${sums[i]}" "${seen[i]}"; done >"$stamp.inputs.new"
  mv -f -- "$stamp.inputs.new" "$stamp.inputs"
}

if [ -n "$here" ]; then
  "$@"
  status=$?
  if [ ${#files[@]} -gt 0 ] && [[ $stamp = */.stamps/* ]] && { [ $status -eq 0 ] || [ $status -eq 6 ]; }; then
    mapfile -t sums < <(sha256sum -b -- "${files[@]}" | sed -E 's/^\\?([0-9a-f]+).*/\1/')
    remember_inputs "${sums[@]}"
  fi
  exit $status
fi

# --- Its note, and the files before it ------------------------------------------------------------------------------

note=$stamp.job
if [[ $note != /* ]]; then note=$PWD/$note; fi
run=${note%/.stamps/*}
run=${run##*/}
start=$(start_of $$)
srun=- guard= token=

declare -A before=()
folders=()
for output in "${outputs[@]}"; do
  folder=./
  if [[ $output = */* ]]; then folder=${output%/*}; fi
  if [ -d "$folder" ] && [[ " ${folders[*]} " != *" $folder "* ]]; then folders+=("$folder"); fi
done
# A file by what it is, then its time in nanoseconds.
list_files() {
  if [ ${#folders[@]} -gt 0 ]; then find "${folders[@]}" -maxdepth 4 -type f ! -path '*/.*' -printf '%i/%s/%T@ %p\n'; fi
}
while read -r identity file; do before[$file]=$identity; done < <(list_files)

write_note() { # TOKEN NAME STAGE
  {
    printf '%s\0' "$1" "$HOSTNAME $$ $start" "$2" "$3" "$seconds" "$PWD"
    printf '%s\0' ${#files[@]}
    for i in "${!files[@]}"; do printf '%s\0' "${seen[i]%% *}" "${files[i]}"; done
    printf '%s\0' ${#outputs[@]} "${outputs[@]}"
    # Workers have make's environment; what a recipe adds to it comes with the job. No key is among these.
    local variables=()
    if [ -n "${PM_QUEUE:-}" ]; then mapfile -t variables < <(compgen -e | grep -E '^PM_(ASKED_[A-Z_]+|SCENE_FILE|CANDIDATE)$'); fi
    printf '%s\0' ${#variables[@]}
    for variable in "${variables[@]}"; do printf '%s=%s\0' "$variable" "${!variable}"; done
    printf '%s\0' "${command[@]}"
  } >"$note.new" && mv -f -- "$note.new" "$note"
}

clear_up() {
  if [ -n "$guard" ]; then kill -KILL "$guard" 2>/dev/null; wait "$guard" 2>/dev/null; guard=; fi
  rm -f -- "$note" "$note".*
}
fail() { # STATUS WORDS
  printf '%s: error: %s\n' "$run/$job" "$2" >&2
  clear_up
  exit "$1"
}
end_by_signal() { # STATUS
  trap '' TERM INT HUP
  rm -f -- "$note"
  if [ "$srun" != - ]; then kill -TERM "$srun" 2>/dev/null; fi
  if [ -n "$token" ] && [ -z "${PM_QUEUE:-}" ]; then cancel "$called"; fi
  if [ "$srun" != - ]; then
    for _ in 1 2 3 4 5 6; do kill -0 "$srun" 2>/dev/null || break; nap 0.5; done
    kill -KILL "$srun" 2>/dev/null
  fi
  clear_up
  exit "$1"
}
trap 'end_by_signal 143' TERM
trap 'end_by_signal 130' INT
trap 'end_by_signal 129' HUP

# --- One try --------------------------------------------------------------------------------------------------------

if [ -n "${PM_QUEUE:-}" ] && read -r worker_cores worker_memory worker_seconds < <(cat -- "$PM_QUEUE/worker" 2>/dev/null); then
  if [ "$cores" -gt "$worker_cores" ] || [ "$memory" -gt "$worker_memory" ] || [ "$seconds" -gt "$worker_seconds" ]; then
    fail 2 "the stage $stage asks for $cores cores, $memory MiB, $seconds s: a worker has $worker_cores cores, $worker_memory MiB, $worker_seconds s (RESOURCES)"
  fi
fi
command=("$@")
# Make's place in its own jobs is nothing for a node.
unset MAKEFLAGS MFLAGS MAKELEVEL
excluded=()
# try_srun: sets srun_status; what srun and the command print goes to the note's messages, and out when it has ended.
try_srun() {
  local options=(--quiet --ntasks=1 --nodes=1 "--cpus-per-task=$cores" "--mem=${memory}M" "--job-name=$called" "--chdir=$PWD" --kill-on-bad-exit=1)
  # Slurm counts in minutes; the node's own watch is exact and comes first.
  options+=("--time=$(((seconds + 59) / 60 + 2))")
  if [ "$gpus" -gt 0 ]; then options+=("--gres=gpu:$gpus"); fi
  if [ -n "${SLURM_JOB_ID:-}" ]; then options+=(--exact); fi
  if [ ${#excluded[@]} -gt 0 ]; then options+=("--exclude=$(IFS=,; echo "${excluded[*]}")"); fi
  LC_ALL=C setsid srun "${options[@]}" "${options_of_stage[@]}" bash "$scripts/slurm-node.sh" "$note" "$token" \
    </dev/null >"$note.output" 2>"$note.messages" &
  srun=$!
  echo "$srun $(start_of "$srun")" >"$note.srun"
  wait "$srun"
  srun_status=$?
  srun=-
}
# The same by the workers of an array job.
try_queue() {
  local entry=$EPOCHREALTIME-$token watch watch_start beats=0
  : >"$note.output"
  : >"$note.messages"
  # Another node is better, if there is one.
  if [ $lost -gt 2 ]; then excluded=(); fi
  printf '%s\0' "$note" "$token" "$seconds" ",$(IFS=,; echo "${excluded[*]}")," >"$PM_QUEUE/new/$entry" && mv -- "$PM_QUEUE/new/$entry" "$PM_QUEUE/todo/$entry"
  srun_status=137
  while [ -d "$PM_QUEUE/todo" ]; do
    nap 0.05
    if [ -e "$PM_QUEUE/done/$entry" ]; then srun_status=0; break; fi
    if [ -e "$PM_QUEUE/lost/$entry" ]; then cat -- "$PM_QUEUE/lost/$entry" >>"$note.messages"; break; fi
    beats=$((beats + 1))
    if [ $((beats % 100)) -eq 0 ]; then
      read -r watch watch_start < <(cat -- "$PM_QUEUE/watch" 2>/dev/null)
      if ! lives "${watch:-0}" "${watch_start:-}"; then bash "$scripts/slurm-workers.sh" "$PM_QUEUE" watch "$make"; fi
    fi
  done
  rm -f -- "$PM_QUEUE/todo/$entry" "$PM_QUEUE/done/$entry" "$PM_QUEUE/lost/$entry"
}

has_ended() { local word value; { read -r word value <"$note.ended"; } 2>/dev/null && [ "$value" = "$token" ]; }
# Of Slurm's own lines only: the command's say what they like.
slurm_said() { [ -s "$note.messages" ] && grep -qE "^(srun|slurmstepd[^:]*): .*($1)" "$note.messages"; }
show() { # what came of the try, and Slurm's words where it failed
  if [ -s "$note.output" ]; then cat -- "$note.output"; fi
  if [ "${1:-}" = all ]; then cat -- "$note.messages" >&2; elif [ -s "$note.messages" ]; then grep -vE '^(srun|slurmstepd[^:]*): ' -- "$note.messages" >&2; fi
}
# --- Until it is done -----------------------------------------------------------------------------------------------

setsid bash "$scripts/slurm-guard.sh" $$ "$start" "$make" "$(start_of "$make")" $PPID "$(start_of $PPID)" "$note" </dev/null >/dev/null 2>&1 &
guard=$!
options_of_stage=("${options[@]}")
lost=0 more_memory= more_time=
while true; do
  token=$HOSTNAME-$$-$start-$lost$more_memory$more_time-$RANDOM
  called=$run/$job
  called=${called//[^A-Za-z0-9._\/-]/_}:$token
  if [ $lost$more_memory$more_time != 0 ]; then rm -f -- "$note".*; fi
  write_note "$token" "$called" "$stage" || fail 3 "$note cannot be written"
  clock_then=$(stat -c %.9Y -- "$note")
  if [ -n "${PM_QUEUE:-}" ]; then try_queue; else try_srun; fi

  # Its last word may be seen later than srun's, on a file system that is shared.
  patient=$patience
  if [ $srun_status -gt 128 ] || slurm_said 'error'; then patient=1; fi
  deadline=$((SECONDS + patient))
  until has_ended || [ $SECONDS -ge $deadline ]; do nap 0.2; ls -a -- "${note%/*}" >/dev/null; done

  node= width= status= ended= took=
  sums=() sent=()
  if has_ended; then
    while read -r word value; do
      case $word in
        node) node=$value ;;
        width) width=$value ;;
        seconds) took=$value ;;
        status) status=$value ;;
        ended) ended=$value ;;
        input) sums+=("${value%% *}") ;;
        output) sent+=("$value") ;;
      esac
    done <"$note.ended"
  elif [ -e "$note.where" ]; then
    read -r node _ <"$note.where"
  fi

  if [ "$ended" = time ] || slurm_said 'DUE TO TIME LIMIT'; then
    show
    if [[ " ${PM_RETRY:-} " = *" time "* && -z $more_time ]]; then
      echo "$run/$job: ended after its $seconds s on ${node:-its node}: once more with $((seconds * 2)) s" >&2
      more_time=t seconds=$((seconds * 2))
      continue
    fi
    fail 124 "time-out: it was not done after its $seconds s on ${node:-its node}; give the stage $stage more time (RESOURCES), or RETRY=time"
  elif slurm_said 'exceeded memory limit|Exceeded (job|step) memory limit|oom[-_ ]kill|Out Of Memory|OUT_OF_MEMORY'; then
    show
    if [[ " ${PM_RETRY:-} " = *" memory "* && -z $more_memory ]]; then
      echo "$run/$job: ended out of its $memory MiB on ${node:-its node}: once more with $((memory * 2)) MiB" >&2
      more_memory=m memory=$((memory * 2))
      continue
    fi
    fail 137 "out of memory: its $memory MiB on ${node:-its node} were too few; give the stage $stage more memory (RESOURCES), or RETRY=memory"
  elif [ -n "$status" ] && [ "$ended" != inputs ] && [ "$status" -ne 75 ] &&
    ! { [ "$status" -gt 128 ] && { [ "$ended" = signal ] || slurm_said 'CANCELLED AT|Node failure|step aborted'; }; }; then
    # A disk that is full on one node is none of the command's faults.
    if [ "$status" -eq 3 ] && [ $lost -lt 3 ] && grep -qE 'No space left on device|is the disk full' "$note.messages"; then
      why="no space left on the device of $node"
    elif [ "$status" -eq 132 ]; then
      show
      fail 132 "illegal instruction on $node, whose registers are $width: the tools were built for another processor; build them with ARCH=baseline"
    else
      show
      break
    fi
  elif slurm_said 'CANCELLED AT' && ! slurm_said 'CANCELLED AT .* DUE TO (PREEMPTION|NODE FAILURE|JOB REQUEUE)'; then
    show
    fail 130 "was cancelled on ${node:-its node}"
  elif slurm_said 'nvalid (account|partition|qos|job id|feature|generic resource|reservation|license)|More processors requested|ode configuration is not available|violates accounting|has expired|already completing|Memory required by task|Required node not available|Access/permission denied|Could not establish a configuration'; then
    if [ ${#excluded[@]} -gt 0 ]; then excluded=(); continue; fi
    show all
    fail 2 "Slurm does not take it: see the line above"
  else
    why="lost with ${node:-its node}"
  fi

  # Not the command's end, but its node's, the network's or Slurm's.
  show all
  if [ -z "${PM_QUEUE:-}" ]; then cancel "$called"; fi
  lost=$((lost + 1))
  if [ $lost -ge 8 ]; then fail 75 "$why, $lost times"; fi
  echo "$run/$job: $why; once more" >&2
  if [ -n "$node" ] && [[ " ${excluded[*]} " != *" $node "* ]]; then excluded+=("$node"); fi
  nap $((lost < 5 ? lost : 5 * lost))
done

# --- What it wrote, as it is seen here ------------------------------------------------------------------------------

if [ "$status" -eq 0 ] || [ "$status" -eq 6 ]; then
  deadline=$((SECONDS + patience))
  for line in "${sent[@]}"; do
    size=${line%% *} output=${line#* }
    until [ "$(stat -Lc %s -- "$output" 2>/dev/null)" = "$size" ]; do
      if [ $SECONDS -ge $deadline ]; then fail 75 "$output was not seen here with its $size bytes within $patience s after $node wrote it"; fi
      nap 0.2
      ls -a -- "${output%/*}" >/dev/null
    done
  done
  # A node's clock is not this one's. What was written while the job ran is given a time of this machine's: no older than its
  # start, or what depends on it might look newer; not later than now, or it would look newer than its own stamp.
  touch -- "$note"
  clock_now=$(stat -c %.9Y -- "$note")
  late=()
  while read -r identity file; do
    if [ "${before[$file]:-}" = "$identity" ]; then continue; fi
    when=${identity##*/}
    fraction=${when#*.}000000000
    when=${when%.*}${fraction:0:9}
    if [ "$when" -lt "${clock_then/./}" ] || [ "$when" -gt "${clock_now/./}" ]; then late+=("$file"); fi
  done < <(list_files)
  if [ ${#late[@]} -gt 0 ]; then touch -c -- "${late[@]}"; fi
  remember_inputs "${sums[@]}"
  if [[ $stamp = */.stamps/* ]]; then printf '%s %s %s\n' "$node" "$width" "$took" >"$stamp.ran"; fi
fi
clear_up
exit "$status"
