#!/bin/bash
# batch-status.sh BATCH [EVERY]: what of a batch runs where, and about how long it will take; with EVERY again after so many seconds, until
# the batch has come to its end. Times left are those of jobs of the same stage so far.
set -u
batch=$1 every=${2:-}
[ -d "$batch/.live" ] || { echo "$batch: no batch has run there" >&2; exit 2; }
cd -- "$batch" || exit

# where MARK: the node of a job that its executor has put on one; "waits" where it has none yet.
where() {
  local name=${1%%@*} job=${1#*@} node
  if [ -e "$name/.stamps/$job.job" ]; then
    read -r node _ 2>/dev/null <"$name/.stamps/$job.job.where" || node='(waits)'
    printf '%s' "$node"
  else
    printf '%s' "$2"
  fi
}

show() {
  local now mark began host pid
  printf -v now '%(%s)T' -1
  {
    sed 's/^/scene /' .live/scenes
    sed 's/^/time /' .live/times 2>/dev/null
    for mark in .live/running/*; do
      { read -r began host pid <"$mark"; } 2>/dev/null || continue
      # Of a job whose process was killed.
      if [ "$host" = "$HOSTNAME" ] && [ ! -d "/proc/$pid" ]; then continue; fi
      mark=${mark##*/}
      printf 'job %s %s %s %d\n' "${mark%%@*}" "${mark#*@}" "$(where "$mark" "$host")" $((now - ${began%[.,]*}))
    done
    find . -mindepth 2 -maxdepth 2 -name batch.status -printf '%h ' -exec cat -- {} \; | sed 's/^\.\//status /'
    # What is done of a scene, and which candidates it has.
    find . -mindepth 3 -maxdepth 3 -path '*/.stamps/*' -type f ! -name '*.*' -printf 'stamp %P\n' | sed 's/\/.stamps\// /'
    find . -mindepth 3 -maxdepth 3 -path '*/candidates/round?.mk' -printf '%h ' -exec cat -- {} \; | sed -n 's/^\.\/\([^/]*\)\/candidates PM_ROUND\([0-9]\) := /ids \1 \2 /p'
  } | awk '
    function median(stage,   n, list, i, j, t) {
      n = split(times[stage], list, " ")
      if (!n) return -1
      for (i = 2; i <= n; ++i) { t = list[i] + 0; for (j = i - 1; j && list[j] + 0 > t; --j) list[j + 1] = list[j]; list[j + 1] = t }
      return list[int((n + 1) / 2)] + 0
    }
    function stage_of(job) { sub(/[-0-9].*/, "", job); return job }
    function span(s) { return s < 0 ? "?" : s < 100 ? sprintf("%d s", s + 0.5) : s < 6000 ? sprintf("%d min", s / 60 + 0.5) : sprintf("%.1f h", s / 3600) }
    function usual(stage) { if (!(stage in known)) known[stage] = median(stage); return known[stage] }
    $1 == "scene" { ++scenes; of_batch[$2] = 1 }
    # The last hundred of a stage say enough.
    $1 == "time" { if (++seen[$2] % 100 == 1) times[$2] = ""; times[$2] = times[$2] " " $3 }
    $1 == "status" && $2 in of_batch { ended[$2] = 1; ++count[$3 == 0 ? "accepted" : $3 == 6 ? "none admitted" : "failed"] }
    $1 == "job" { job[++jobs] = $2 " " $3 " " $4 " " $5; if ($4 == "(waits)") ++waiting; running[$2, $3] = 1 }
    $1 == "stamp" { done[$2, $3] = 1 }
    $1 == "ids" { for (i = 4; i <= NF; ++i) ids[$2] = ids[$2] " " $i; rounds[$2] = $3 }
    function add(scene, job,   t) {
      if ((scene, job) in done || (scene, job) in running) return
      t = usual(stage_of(job)); if (t > 0) work += t
    }
    END {
      over = count["accepted"] + count["none admitted"] + count["failed"]
      printf "%d scenes: %d accepted, %d with none admitted, %d failed, %d to go; %d jobs run, %d wait\n", scenes, count["accepted"], count["none admitted"], count["failed"], scenes - over, jobs - waiting, waiting
      if (jobs) print "scene\tjob\twhere\tfor\tleft"
      for (i = 1; i <= jobs; ++i) {
        split(job[i], f, " "); left = usual(stage_of(f[2])); if (left >= 0) left = left > f[4] ? left - f[4] : 0
        if (left > 0) work += left
        print f[1] "\t" f[2] "\t" f[3] "\t" span(f[4]) "\t" span(left)
      }
      if (jobs && scenes > over) {
        for (s in of_batch) if (!(s in ended)) {
          add(s, "spec"); add(s, "ground"); add(s, "lift"); add(s, "material"); add(s, "candidates0")
          n = split(ids[s], list, " ")
          for (i = 1; i <= n; ++i) { add(s, "simulate-" list[i]); add(s, "render-" list[i]) }
          if (!n) { t = usual("simulate") + usual("render"); if (t > 0) work += 6 * t }
          for (r = 0; r <= rounds[s] + 0; ++r) { add(s, "camera" r); add(s, "screen" r) }
        }
        print "about " span(work / (jobs - waiting > 0 ? jobs - waiting : 1)) " left for the rounds that are known"
      }
    }'
}

while true; do
  table=$(show)
  if [ -t 1 ] && [ -n "$every" ]; then printf '\033[H\033[J'; fi
  grep -v $'\t' <<<"$table" | head -n 1
  grep $'\t' <<<"$table" | column -t -s $'\t'
  grep '^about ' <<<"$table"
  if [ -z "$every" ] || ! grep -q ' [1-9][0-9]* to go' <<<"$table"; then break; fi
  sleep "$every"
done
