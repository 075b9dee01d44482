#!/bin/bash
# hardening.sh BUILD OUT KILLS MUTATIONS INJECTIONS FAULTS: attacks the tools of BUILD in every way that the project knows (docs/security.md) and
# prints a table. FAULTS: the command that injects faults into system calls, or nothing. What failed is in OUT; exit code 1 where anything did.
set -u
build=$(realpath "$1") out=$2 kills=$3 mutations=$4 injections=$5 faults=$6
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
mkdir -p "$out"
out=$(realpath "$out")
table=$out/table.tsv
printf 'attack\ttried\tfailed\tseconds\n' >"$table"
unset MAKEFLAGS MFLAGS MAKELEVEL
failed=0

row() { # NAME TRIED FAILED SECONDS
  printf '%s\t%s\t%s\t%s\n' "$@" >>"$table"
  [ "$3" = 0 ] || failed=1
}

# bats_row NAME FILE...: the tests of these files.
bats_row() {
  local name=$1 log=$out/${1// /-}.log
  shift
  SECONDS=0
  (cd "$root" && INJECTIONS=$injections PM_BIN=$build/bin bats --tap "$@") >"$log" 2>&1
  local tests bad
  tests=$(grep -c '^ok' "$log") bad=$(grep -c '^not ok' "$log")
  if [ $((tests + bad)) -eq 0 ]; then bad=1; fi
  local tried="$((tests + bad)) tests"
  if grep -q '^# tried ' "$log"; then tried="$(sed -n 's/^# tried \([0-9]*\).*/\1/p' "$log" | awk '{ s += $1 } END { print s }') texts"; fi
  row "$name" "$tried" "$bad" "$SECONDS"
}

# Beside all else: the other attacks wait for one process most of the time.
SECONDS=0
if [ -n "$faults" ]; then
  echo "faults of system calls, meanwhile"
  ($faults >"$out/faults.log" 2>&1; echo $? >"$out/faults.status"; echo "$SECONDS" >"$out/faults.seconds") &
fi

echo "kill storm"
python3 -B "$root/tests/hardening/kill_storm.py" "$build/bin" "$out/kills" "$kills" >"$out/kills.row" 2>"$out/kills.log" || failed=1
if [ -s "$out/kills.row" ]; then cat "$out/kills.row" >>"$table"; else row "kill storm" "$kills kills" 1 0; fi

echo "mutated inputs of the readers"
targets=$(cd "$root/tests/fuzz" && ls -- *.cpp | grep -v driver | sed 's/\.cpp$//')
each=$((mutations / $(wc -w <<<"$targets") + 1))
SECONDS=0 tried=0 bad=0
mkdir -p "$out/mutations"
for target in $targets; do
  (mkdir -p "$out/mutations/$target" && cd "$out/mutations/$target" &&
    "$build/test/fuzz/$target" -runs=$each -max_total_time=120 "$root/tests/fuzz/corpus/$target") >"$out/mutations/$target.log" 2>&1 || { bad=$((bad + 1)); echo "  $target: see $out/mutations/$target.log"; }
  tried=$((tried + $(sed -n 's/^\([0-9]*\) inputs.*/\1/p' "$out/mutations/$target.log" | tail -n 1)))
done
row "mutated inputs of $(wc -w <<<"$targets") readers" "$tried inputs" $bad "$SECONDS"

echo "mutated files of the tools"
python3 -B "$root/tests/hardening/mutate_files.py" "$build/bin" "$out/files" $((mutations / 200)) >"$out/files.row" 2>"$out/files.log" || failed=1
if [ -s "$out/files.row" ]; then cat "$out/files.row" >>"$table"; else row "mutated files" 0 1 0; fi

echo "injections through make"
bats_row "injections through make" tests/cli/injection.bats
echo "changed files of a run"
bats_row "changed files of a run" tests/cli/audit.bats
echo "hostile servers"
bats_row "hostile servers" tests/cli/remote.bats tests/cli/ground-faults.bats tests/cli/ground-models.bats

if [ -n "$faults" ]; then
  wait
  row "faults of system calls" "$(sed -nE 's/.* ([0-9]+) of +[0-9]+ calls:.*/\1/p' "$out/faults.log" | awk '{ n += $1 } END { print n + 0 }') faults" "$(cat "$out/faults.status")" "$(cat "$out/faults.seconds")"
fi
column -t -s "$(printf '\t')" "$table"
exit $failed
