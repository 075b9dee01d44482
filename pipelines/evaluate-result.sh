#!/bin/bash
# evaluate-result.sh STATUS SCENE RUN REFERENCE OUT CANDIDATE OBJECT...: what came out of a method's run (make's exit STATUS) in
# the folder RUN: measures every object against the REFERENCE's rollout and writes OUT/result.tsv (lib/tables/suite.h). For
# evaluate.mk. CANDIDATE: the result whether it was admitted or not; empty: the accepted candidate.
set -u
status=$1 scene=$2 run=$3 reference=$4 out=$5 candidate=$6
shift 6

finish() { # FIELD...
  (IFS=$'\t' && printf '%s\n' "$*") >"$out/result.tsv"
  exit 0
}

echo "$status 0" >"$run/batch.status"
"$BIN/pm-screen" --table "$run" --out "$out/table.tsv" || finish failed "pm-screen --table failed"
IFS=$'\t' read -r _ result accepted _ _ _ _ simulate render reason < <(tail -n 1 "$out/table.tsv")
case $result in
  accepted) candidate=${candidate:-$accepted} ;;
  "none admitted") [ -n "$candidate" ] || finish failed "no candidate was admitted: $reason" ;;
  *) finish failed "$reason" ;;
esac
[ "$(cut -f1 "$reference/result.tsv")" = done ] || finish failed "its reference failed: $(cut -f2 "$reference/result.tsv")"
[ -e "$run/videos/$candidate.mp4" ] || finish failed "$candidate has no video: it diverged"
for object in "$@"; do
  "$BIN/pm-eval" motion --scene "$scene" --inventory "$(dirname "$scene")/inventory.json" --state "$reference/state.h5" \
    --rollout "$run/rollouts/$candidate.h5" --reference "$reference/rollout.h5" --target "$object" \
    --out "$out/motion-$object.json" >"$out/motion.txt" 2>&1 || finish failed "$(tail -n 1 "$out/motion.txt" | cut -c -300)"
done
finish done "$candidate" "$(awk -v a="$simulate" -v b="$render" 'BEGIN { printf "%.2f", a + b }')"
