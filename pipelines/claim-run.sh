#!/bin/bash
# claim-run.sh RUN SOURCE FILE: whether the folder RUN is free for the scene SOURCE, "GAUSSIANS=/scans/chair.ply": prints
# nothing, or in one line why not. RUN/source holds the source and the SHA-256 of its FILE, if it has one: a file that was
# moved is still the same.
run=$1 source=$2 file=$3
sum() { if [ -f "$file" ]; then sha256sum <"$file" | cut -c -64; fi; }

if [ -e "$run/source" ]; then
  { IFS= read -r before; IFS= read -r sum_before; } <"$run/source"
  if [ "$before" = "$source" ]; then exit; fi
  if [ -z "$sum_before" ] || [ "$(sum)" != "$sum_before" ]; then
    echo "$run is the run of $before: give $source a folder of its own with RUN=runs/name, or remove $run"
  fi
elif [ -d "$run" ]; then
  printf '%s\n%s\n' "$source" "$(sum)" >"$run/source"
fi
