#!/bin/bash
# slurm-node.sh NOTE TOKEN: a job on its node, for slurm-job.sh: waits until the note and its inputs are seen here, runs the
# command within its time, and leaves NOTE.ended, whole or not at all. Ends the command where the note is gone or has another
# token: nobody waits for it any more.
#
# NOTE.ended, a word and its values per line: token, node, width (of the processor's registers, as far as the tools use them),
# seconds, status (the command's), ended (time, lease, inputs: why it was not let go on), input SHA256 NAME, output SIZE NAME.
set -u
note=$1 token=$2
source "$(dirname -- "${BASH_SOURCE[0]}")/job-files.sh"
patience=${PM_PATIENCE:-60}
node=${SLURMD_NODENAME:-$(uname -n)}

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
  lines+=("seconds $((SECONDS - begun))" "status $1" ${2:+"ended $2"})
  { printf '%s\n' "${lines[@]}" >"$note.$token" && mv -f -- "$note.$token" "$note.ended"; } ||
    { rm -f -- "$note.$token"; echo "$node: $note.ended cannot be written" >&2; exit 75; }
  exit "$1"
}
begun=$SECONDS
echo "$node $(date +%s)" >"$note.where" 2>/dev/null

# What make saw is what this node has to see; a file system that is shared may take a while.
count=${fields[at]}
inputs=()
for ((i = 0; i < count; ++i)); do
  size=${fields[at + 1 + 2 * i]} file=${fields[at + 2 + 2 * i]}
  until [ "$(stat -Lc %s -- "$file" 2>/dev/null)" = "$size" ]; do
    if [ $SECONDS -ge $deadline ]; then
      echo "$node: $file was not seen with its $size bytes within $patience s" >&2
      finish 75 inputs
    fi
    nap 0.2
  done
  inputs+=("$file")
done
at=$((at + 1 + 2 * count))
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

env "${environment[@]}" "${command[@]}" </dev/null &
tool=$!
# Why it was ended, from the watch to here.
why=$(mktemp)
(
  exec {napping}<> <(:)
  deadline=$((SECONDS + limit)) ending=
  while true; do
    nap 1
    # Seen by another name of the folder, a note that is there may be missed once.
    if [ "$(token_in "$note")" != "$token" ]; then nap 0.5; [ "$(token_in "$note")" = "$token" ] || ending=lease; fi
    if [ "$limit" -gt 0 ] && [ $SECONDS -ge $deadline ]; then ending=time; fi
    if [ -n "$ending" ]; then
      echo $ending >"$why"
      kill -TERM $tool
      nap 5
      kill -KILL $tool
      break
    fi
  done
) >/dev/null 2>&1 &
watch=$!
# Slurm ends a job with SIGTERM: the tool removes what is half written.
trap 'kill -TERM $tool 2>/dev/null' TERM INT HUP
while true; do
  wait $tool
  status=$?
  if ! kill -0 $tool 2>/dev/null; then break; fi
done
kill $watch 2>/dev/null
reason=$(<"$why")
rm -f -- "$why"
if [ "$reason" = lease ]; then exit 75; fi
for file in "${outputs[@]}"; do
  if size=$(stat -Lc %s -- "$file" 2>/dev/null); then lines+=("output $size $file"); fi
done
finish $status ${reason:+"$reason"}
