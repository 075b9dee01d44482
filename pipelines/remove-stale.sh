#!/bin/bash
# remove-stale.sh RUN ROUND STAGE: takes out of a run what is no longer part of it, after STAGE of ROUND has written its
# record and before its stamp is touched. Other candidates: what was accepted of the former ones and later rounds go. A screen
# that asks for no repairs: later rounds go. Then all files of candidates that no round has any more: RUN/.stamps/ids holds
# all that it ever had, so that a file of the user's own stays.
set -eu
run=$1 round=$2 stage=$3
ids=$run/.stamps/ids
# What is no id names no file of a run.
ids_of() { sed -n 's/^PM_ROUND[0-9] *:= *//p' "$@" | tr ' ' '\n' | grep -xE '[a-z0-9-]+' || true; }

later=
if [ "$stage" = screen ]; then
  if ! grep -q '^PM_DECISION.*repair' "$run/screen/round$round.mk"; then later=1; fi
elif [ ! -e "$run/.stamps/candidates$round" ] || [ "$run/candidates/round$round.json" -nt "$run/.stamps/candidates$round" ]; then
  later=1
  rm -f "$run"/{final,best}.mp4 "$run/accepted.json"
fi
if [ -n "$later" ]; then
  for n in 1 2; do
    if [ "$n" -gt "$round" ]; then rm -f "$run"/{candidates,screen}/round"$n".{json,mk} "$run/cameras/round$n.json"; fi
  done
fi

touch "$ids"
mapfile -t former < <(grep -xE '[a-z0-9-]+' "$ids" || true)
ids_of "$run"/candidates/round?.mk | sort -u >"$ids.new"
for id in "${former[@]}"; do
  if ! grep -qxF -- "$id" "$ids.new"; then
    rm -f "$run/candidates/$id.json" "$run"/{rollouts,videos}/"$id".* "$run"/.stamps/{simulate,render}-"$id"{,.log,.files,.inputs,.ran}
  fi
done
mv "$ids.new" "$ids"
