#!/bin/bash
# batch-end.sh BATCH RUN STATUS: a scene of a batch has come to its end, accepted (0) or not (6). Notes all that it rests on, for
# batch-settled.sh. EXAMPLES and PM_ASKED_* say what it was asked for.
set -u
batch=$1 run=$2 status=$3 name=${2##*/}
began=$EPOCHREALTIME
if [ -e "$run/.stamps/begun" ]; then began=$(<"$run/.stamps/begun"); fi
span=$((${EPOCHREALTIME/[.,]/} - ${began/[.,]/}))
printf '%d %d.%03d\n' "$status" $((span / 1000000)) $((span / 1000 % 1000)) >"$run/batch.status"
printf '  %-13s  %s\n' "$([ "$status" -eq 0 ] && echo accepted || echo 'none admitted')" "$run"

roots=()
add_root() {
  if [ -e "$1" ]; then roots+=("$(realpath -- "$1")"); fi
}
for variable in SPEC INVENTORY PLAN DATAPARSER PHYSGAUSSIAN MATERIALS AUTHORED PREDICTOR MASKS VIEWS GAUSSIANS CAMERAS SCENE_AGENT PERCEPTION AGENT; do
  value=PM_ASKED_$variable
  value=${!value:-}
  if [ -n "$value" ]; then add_root "${value#replay:}"; fi
done
if [ -n "${PM_ASKED_SCENE:-}" ]; then add_root "$(dirname -- "$PM_ASKED_SCENE")"; fi
if [ -n "${PM_ASKED_EXAMPLE:-}" ]; then add_root "$EXAMPLES$PM_ASKED_EXAMPLE.json"; fi

source "${BASH_SOURCE[0]%/*}/batch-files.sh"
cd -- "$batch" || exit
{
  printf 'run\t%s\n' "$name"
  printf 'asked\t%s\n' "$(cksum <.asked)"
  grep -m1 -e "^${name//./\\.}"$'\t' scenes.list | sed 's/^/line\t/'
  for root in "${roots[@]}"; do printf 'root\t%s\n' "$root"; done
  if [ ${#roots[@]} -gt 0 ]; then printf '%s\0' "${roots[@]}" | files_elsewhere | sed 's/^/file\t/'; fi
  printf '%s\0' "$name" | files_of_runs | sed 's/^/file\t/'
} >"$name/.stamps/settled.new" 2>/dev/null
mv -f -- "$name/.stamps/settled.new" "$name/.stamps/settled"
exit 0
