#!/bin/bash
# slurm-before.sh RUN: before make looks at the times of a run's files. What another machine's clock or a copy did to them is set right by
# what lies in them: beside the stamp of a stage stand the hashes of what it read (STAGE.inputs). Where these are still the same the stamp
# is made newer than they; where they are not, it is removed. A job that a killed make left is cancelled.
set -u
stamps=$1/.stamps
[ -d "$stamps" ] || exit 0
source "${BASH_SOURCE[0]%/*}/job-files.sh"
shopt -s nullglob

for note in "$stamps"/*.job; do
  mapfile -d '' -t fields <"$note"
  read -r host process started <<<"${fields[1]:-}"
  if [ "$host" = "$HOSTNAME" ] && lives "${process:-0}" "${started:-}"; then
    echo "$1: another make waits for the job ${fields[2]}: wait for it, or end it" >&2
    exit 1
  fi
  rm -f -- "$note" "$note".*
  cancel "${fields[2]:-}"
done

records=()
for record in "$stamps"/*.inputs; do
  if [ -e "${record%.inputs}" ]; then records+=("$record"); fi
done
[ ${#records[@]} -gt 0 ] || exit 0

# Times later than now: stamps, and what stages made. `now` is the file system's.
touch -- "$stamps/now"
find "$1" -maxdepth 4 -type f -newer "$stamps/now" -exec touch -c -r "$stamps/now" -- {} +

declare -A now=() sum=()
names=() doubtful=()
while read -r _ _ _ name; do
  if [ -z "${now[$name]:-}" ]; then now[$name]=gone names+=("$name"); fi
done < <(cat -- "${records[@]}")
while read -r size time name; do now[$name]="$size $time"; done < <(stat -Lc '%s %.9Y %n' -- "${names[@]}" 2>/dev/null)
while read -r hash size time name; do
  if [ "${now[$name]}" != "$size $time" ] && [ "${now[$name]}" != gone ] && [ -z "${sum[$name]:-}" ]; then sum[$name]=? doubtful+=("$name"); fi
done < <(cat -- "${records[@]}")
if [ ${#doubtful[@]} -gt 0 ]; then
  while read -r hash name; do sum[${name#\*}]=$hash; done < <(sha256sum -b -- "${doubtful[@]}")
fi

for record in "${records[@]}"; do
  stamp=${record%.inputs}
  when=$(stat -c %.9Y -- "$stamp")
  when=${when/./} older= changed= lines=
  while read -r hash size time name; do
    if [ "${now[$name]}" = gone ]; then continue; fi
    if [ "${now[$name]}" != "$size $time" ] && [ "${sum[$name]}" != "$hash" ]; then changed=1; break; fi
    seen=${now[$name]#* }
    if [ "${seen/./}" -gt "$when" ]; then older=1; fi
    lines+="$hash ${now[$name]} $name"$'\n'
  done <"$record"
  if [ -n "$changed" ]; then
    rm -f -- "$stamp" "$record"
  elif [ -n "$older" ] || [ "$lines" != "$(<"$record")"$'\n' ]; then
    printf '%s' "$lines" >"$record.new" && mv -f -- "$record.new" "$record"
    if [ -n "$older" ]; then touch -r "$stamps/now" -- "$stamp"; fi
  fi
done
exit 0
