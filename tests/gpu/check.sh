#!/usr/bin/env bash
# Everything that only a GPU can tell, in one go: builds the solver with kernels for the card of this machine, runs its tests on
# the card, two tools of NVIDIA's that look for wrong accesses and races, and the benchmark beside the CPU, and writes a report.
#
#   tests/gpu/check.sh [REPORT]       REPORT: runs/gpu-report.txt by default
#
# Needs g++, make, nvcc and a driver, no other package and no network; at most eight minutes (SECONDS_ALLOWED=480): what does not
# fit is left out, and the report says so. Exit code 0: all that ran passed, and the tests ran.
set -uo pipefail
cd "$(dirname "$0")/../.."
report=${1:-runs/gpu-report.txt}
allowed=${SECONDS_ALLOWED:-480}
out=${OUT:-build/gpu}
mkdir -p "$(dirname "$report")" "$out"
: >"$report"
say() { printf '%s\n' "$*" | tee -a "$report"; }
left() { echo $((allowed - SECONDS)); }
failed=0

# step NAME MOST_SECONDS COMMAND...: into the report, cut off in time.
step() {
  local name=$1 most=$2 begin=$SECONDS status=0 time
  shift 2
  time=$(left)
  if [ "$time" -gt "$most" ]; then time=$most; fi
  if [ "$time" -lt 5 ]; then say "== $name: left out, no time is left"; return 0; fi
  say "== $name"
  timeout -k 5 "$time" "$@" >"$out/step.log" 2>&1 || status=$?
  tail -n 120 "$out/step.log" | tee -a "$report"
  if [ "$status" -eq 124 ] || [ "$status" -eq 137 ]; then
    say "== $name: cut off after $time s"
  elif [ "$status" -ne 0 ]; then
    say "== $name: FAILED with exit code $status, $((SECONDS - begin)) s"
    failed=1
  else
    say "== $name: done, $((SECONDS - begin)) s"
  fi
  return "$status"
}

nvcc=$(command -v nvcc || ls /usr/local/cuda/bin/nvcc 2>/dev/null) || nvcc=
if [ -z "$nvcc" ]; then say "nvcc not found: nothing to check"; exit 2; fi
if ! nvidia-smi >/dev/null 2>&1; then say "no driver or no card: nothing to check (the emulator's tests are in make test)"; exit 2; fi
arch=${CUDA_ARCH:-$(nvidia-smi --query-gpu=compute_cap --format=csv,noheader | head -1 | tr -d .)}
say "revision: $(git rev-parse --short HEAD 2>/dev/null || echo unknown)"
say "card: $(nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader | head -1), compute capability $arch"
say "nvcc: $("$nvcc" --version | tail -1)"
say "processor: $(sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1), $(nproc) cores"

step build 300 make -f tests/gpu/bare/bare.mk -j"$(nproc)" OUT="$out" NVCC="$nvcc" CUDA_ARCH="$arch" || exit 1
if ! step "tests on the card" 120 env PM_GPU=1 "$out/check"; then failed=1; fi
step "tests on the card, ten times the particles" 60 env PM_GPU=1 PM_SCALE=10 "$out/check" "every law"
step "laws on the card" 60 bash -c "'$nvcc' -std=c++17 -O2 -Ilib -Itests -arch=sm_$arch tests/cuda/laws.cu -o '$out/laws' && '$out/laws'"
step bench 150 "$out/bench"
sanitizer=$(command -v compute-sanitizer || ls "$(dirname "$nvcc")/compute-sanitizer" 2>/dev/null) || sanitizer=
if [ -z "$sanitizer" ]; then
  say "== compute-sanitizer not found: left out"
else
  step memcheck 60 env PM_GPU=1 "$sanitizer" --tool memcheck --error-exitcode 9 "$out/check" "no particle"
  step racecheck 60 env PM_GPU=1 "$sanitizer" --tool racecheck --error-exitcode 9 "$out/check" "no particle"
  step "memcheck of more" 60 env PM_GPU=1 "$sanitizer" --tool memcheck --error-exitcode 9 "$out/check" "bodies that meet"
  step "racecheck of more" 60 env PM_GPU=1 "$sanitizer" --tool racecheck --error-exitcode 9 "$out/check" "an interval in parts"
fi
say "== $([ "$failed" -eq 0 ] && echo passed || echo FAILED) after $SECONDS s; report: $report"
exit "$failed"
