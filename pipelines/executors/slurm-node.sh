#!/bin/bash
# slurm-node.sh NOTE TOKEN: a job on its node, for slurm-job.sh: waits until the note and its inputs are seen here, runs the
# command within its time, and leaves NOTE.ended, whole or not at all. Ends the command where the note is gone or has another
# token: nobody waits for it any more.
#
# NOTE.ended, a word and its values per line: token, node, width (of the processor's registers, as far as the tools use them),
# seconds, status (the command's), ended (time, lease, inputs, signal: why it was not let go on), input SHA256 NAME, output SIZE NAME.
set -u
note=$1 token=$2
scripts=${BASH_SOURCE[0]%/*}
source "$scripts/job-files.sh"
source "$scripts/../wait-for.sh"
patience=${PM_PATIENCE:-60}
node=${SLURMD_NODENAME:-$HOSTNAME}

deadline=$((SECONDS + patience))
until [ "$(token_in "$note")" = "$token" ]; do
  if [ $SECONDS -ge $deadline ]; then
    echo "$node: $note was not seen within $patience s: is the folder on a shared file system?" >&2
    exit 75
  fi
  nap 0.2
done
mapfile -d '' -t fields <"$note"
limit=${fields[4]} folder=${fields[5]} at=6
cd -- "$folder" || { echo "$node: there is no folder $folder" >&2; exit 75; }

lines=("token $token" "node $node")
finish() { # STATUS [WHY]
  # Nobody waits for it any more.
  if [ "$(token_in "$note")" != "$token" ]; then exit 75; fi
  lines+=("seconds $((SECONDS - begun))" "status $1" ${2:+"ended $2"})
  { printf '%s\n' "${lines[@]}" >"$note.$token" && mv -f -- "$note.$token" "$note.ended"; } ||
    { rm -f -- "$note.$token"; echo "$node: $note.ended cannot be written" >&2; exit 75; }
  exit "$1"
}
begun=$SECONDS
printf '%s %(%s)T\n' "$node" -1 >"$note.where" 2>/dev/null

# What make saw is what this node has to see; a file system that is shared may take a while.
count=${fields[at]}
inputs=() expected=
for ((i = 0; i < count; ++i)); do
  inputs+=("${fields[at + 2 + 2 * i]}")
  expected+="${fields[at + 1 + 2 * i]}"$'\n'
done
at=$((at + 1 + 2 * count))
until [ $count -eq 0 ] || [ "$(stat -Lc %s -- "${inputs[@]}" 2>/dev/null)"$'\n' = "$expected" ]; do
  if [ $SECONDS -ge $deadline ]; then
    echo "$node: not all of ${inputs[*]} were seen as they are within $patience s" >&2
    finish 75 inputs
  fi
  nap 0.2
done
if [ ${#inputs[@]} -gt 0 ]; then
  # A backslash in front of a sum is how sha256sum marks a name that it had to write in another way.
  while read -r sum file; do lines+=("input ${sum#\\} ${file#\*}"); done < <(sha256sum -b -- "${inputs[@]}")
fi
outputs=("${fields[@]:at + 1:fields[at]}")
at=$((at + 1 + fields[at]))
environment=("${fields[@]:at + 1:fields[at]}")
at=$((at + 1 + fields[at]))
command=("${fields[@]:at}")

width=sse2
while IFS=: read -r key flags; do
  if [[ $key = flags* ]]; then
    case " $flags " in *" avx512f "*) width=avx512 ;; *" avx2 "*) width=avx2 ;; esac
    break
  fi
done </proc/cpuinfo
lines+=("width ${PM_KERNELS:-$width}")

reason=
trap 'reason=time' USR1
trap 'reason=lease' USR2
env "${environment[@]}" "${command[@]}" </dev/null &
tool=$!
(
  exec {napping}<> <(:)
  deadline=$((SECONDS + limit)) ending=
  while true; do
    nap 1
    # Seen by another name of the folder, a note that is there may be missed once.
    if [ "$(token_in "$note")" != "$token" ]; then nap 0.5; [ "$(token_in "$note")" = "$token" ] || ending=lease; fi
    if [ "$limit" -gt 0 ] && [ $SECONDS -ge $deadline ]; then ending=time; fi
    if [ -n "$ending" ]; then
      # Its word to the shell below: a signal each, since a disk may be full.
      if [ $ending = time ]; then kill -USR1 $$; else kill -USR2 $$; fi
      kill -TERM $tool
      nap 5
      kill -KILL $tool
      break
    fi
  done
) >/dev/null 2>&1 &
watch=$!
# Slurm ends a job with SIGTERM: the tool removes what is half written.
trap 'reason=${reason:-signal}; kill -TERM $tool 2>/dev/null' TERM INT HUP
wait_for $tool
kill $watch 2>/dev/null
if [ "$reason" = lease ]; then exit 75; fi
if [ ${#outputs[@]} -gt 0 ]; then
  while read -r line; do lines+=("output $line"); done < <(stat -Lc '%s %n' -- "${outputs[@]}" 2>/dev/null)
fi
finish $status ${reason:+"$reason"}
