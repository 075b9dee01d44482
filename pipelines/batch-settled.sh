#!/bin/bash
# batch-settled.sh BATCH: the names of the scenes that were asked for what they have ended with, and of whose files, sources included, none
# has changed since (batch-end.sh): make would find nothing to do. One look at all files, and no process for a scene.
set -u
source "${BASH_SOURCE[0]%/*}/batch-files.sh"
cd -- "$1" 2>/dev/null || exit 0
mapfile -d '' -t records < <(find . -mindepth 3 -maxdepth 3 -path '*/.stamps/settled' -print0)
if [ ${#records[@]} -eq 0 ]; then exit 0; fi
notes=$(printf '%s\0' "${records[@]}" | xargs -0 cat --)
{
  awk -F '\t' '$1 == "run" { printf "%s%c", $2, 0 }' <<<"$notes" | files_of_runs
  awk -F '\t' '$1 == "root" && !seen[$2]++ { printf "%s%c", $2, 0 }' <<<"$notes" | files_elsewhere
} 2>/dev/null | awk -F '\t' -v asked="$(cksum <.asked)" '
  function close_run() { if (run != "" && good && same_line) { bad = 0; for (r in roots) if (counted[r] != count[r]) bad = 1; if (!bad) print run } }
  function rest() { return substr($0, length($1) + 2) }
  FILENAME == "-" { now[$0] = 1; ++count[$1]; next }
  FILENAME == "scenes.list" { line[$1] = $0; next }
  $1 == "run" { close_run(); run = $2; good = 1; same_line = 0; split("", roots); split("", counted) }
  $1 == "asked" { if ($2 != asked) good = 0 }
  $1 == "line" { same_line = rest() == line[run] }
  $1 == "root" { roots[$2] = 1 }
  $1 == "file" { if (!(rest() in now)) good = 0; if ($2 in roots) ++counted[$2] }
  END { close_run() }' - scenes.list <(printf '%s\n' "$notes")
