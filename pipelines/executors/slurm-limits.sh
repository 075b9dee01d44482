#!/bin/bash
# slurm-limits.sh STAGE...: fails, with a line, where the table of resources asks for more of a stage than any node of its partition has, or
# for more time than the partition gives: Slurm lets some of these wait for ever. Where Slurm does not answer, nothing is said.
set -u
scripts=${BASH_SOURCE[0]%/*}
source "$scripts/resources.sh"
read -ra resource_files <<<"$PM_RESOURCES"
# Inside of an allocation its nodes are all there is, whatever their partition.
inside=()
if [ -n "${SLURM_JOB_ID:-}" ]; then inside=(--nodes "${SLURM_JOB_NODELIST:-}"); fi
nodes=$(timeout 10 sinfo --noheader --Node "${inside[@]}" --format '%P|%c|%m|%l|%N' 2>/dev/null) || exit 0

for stage; do
  resources_of "$stage" "${resource_files[@]}" || { printf '%s\n' "$complaint"; exit 1; }
  [ -z "$here" ] || continue
  partition=${SLURM_PARTITION:-}
  for option in "${options[@]}"; do case $option in --partition=*) partition=${option#*=} ;; esac; done
  if [ -n "${SLURM_JOB_ID:-}" ]; then partition=any; fi
  refusal=$(awk -F '|' -v stage="$stage" -v partition="$partition" -v cores="$cores" -v memory="$memory" -v seconds="$seconds" '
    # [days-][[hours:]minutes:]seconds; nothing for "infinite".
    function seconds_of(text,   days, n, part, s, i) {
      if (text !~ /^[0-9]/) return 0
      if (split(text, part, "-") == 2) { days = part[1]; text = part[2] }
      n = split(text, part, ":")
      for (i = 1; i <= n; ++i) s = 60 * s + part[i]
      return 86400 * days + s
    }
    {
      name = $1
      is_default = sub(/\*$/, "", name)
      if (partition != "any" && !(partition == "" ? is_default : index("," partition ",", "," name ","))) next
      ++seen
      limit = seconds_of($4)
      if (limit == 0 || seconds <= limit) in_time = 1; else shortest = name " gives " $4
      if (cores <= $2 + 0 && memory <= $3 + 0) fits = 1
      if ($2 * 1e9 + $3 > largest) { largest = $2 * 1e9 + $3; best = $5 " has " $2 " cores and " $3 + 0 " MiB"; of = name }
    }
    END {
      if (!seen) exit
      if (!fits) printf "%s asks for %d core%s and %d MiB, which no node %s has: the largest, %s", stage, cores, cores == 1 ? "" : "s", memory, partition == "any" ? "of the allocation" : "of the partition " of, best
      else if (!in_time) printf "%s asks for %d s: the partition %s", stage, seconds, shortest
    }' <<<"$nodes")
  if [ -n "$refusal" ]; then
    printf '%s: %s; say less in a file of RESOURCES\n' "$resources_at" "$refusal"
    exit 1
  fi
done
exit 0
