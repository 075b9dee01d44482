#!/usr/bin/env bats
# Executors (pipelines/executors): every tool that a recipe runs is a job, and an executor of one's own gets them all.
load common

clean_make() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory "$@"; }

# Recipe lines of makefiles that run a tool or a script of tools, but not directly behind $(call job,...).
outside_of_jobs() { # FILE...
  python3 - "$@" <<'PY'
import re, sys
tool = re.compile(r"(?:\$+\(BIN\)/\S*|\bpm-[a-z]+|(?:env BIN=\$\(BIN\) )?bash \$\(PIPELINES\)evaluate-[a-z]+\.sh)")
for path in sys.argv[1:]:
    for line in open(path).read().replace("\\\n", " ").split("\n"):
        if not line.startswith("\t"):
            continue
        ends = set()
        for call in re.finditer(r"\$+\(call job,", line):
            depth, at = 1, call.end()
            while depth:
                depth += {"(": 1, ")": -1}.get(line[at], 0)
                at += 1
            ends.add(at)
        for use in tool.finditer(line):
            if len(line[:use.start()].rstrip()) not in ends:
                print(f"{path}: {use.group()} is not run by a job: {line.strip()}")
PY
}

@test "executors: every tool of a recipe runs behind \$(call job)" {
  run outside_of_jobs "$root"/pipelines/*.mk
  echo "$output"
  [ "$status" -eq 0 ]
  [ -z "$output" ]
  # Each of these is found, and what is right is not.
  cd "$BATS_TEST_TMPDIR"
  # shellcheck disable=SC2016
  for wrong in '@$(BIN)/pm-lift --out x' '@$(call job,lift,1,,,) true; $(BIN)/pm-lift' '@$$(call stage,a,b) $(BIN)/pm-lift' 'pm-lift --out x' \
    '@env BIN=$(BIN) bash $(PIPELINES)evaluate-result.sh 0' '@$(call job,a,1,$(x),y,z) $(BIN)/$(TOOL) || $(BIN)/pm-lift'; do
    printf 'x: y\n\t%s\n' "$wrong" >wrong.mk
    [ "$(outside_of_jobs wrong.mk | wc -l)" -eq 1 ] || { echo "not found: $wrong"; return 1; }
  done
  printf 'x: y\n\t@$(call or_base,a,b) \\\n\t$$(call job,lift,$$(threads),$(call f,x),y,) \\\n\t$(BIN)/pm-lift --out x || [ $$? -eq 6 ]\n' >right.mk
  [ -z "$(outside_of_jobs right.mk)" ]
}

@test "executors: one that is not there is refused in one line that names those that are" {
  cd "$BATS_TEST_TMPDIR"
  for executor in nowhere % "local local" missing/mine.mk; do
    for goal in "run SCENE=x/scene.json RUN=$PWD/run" "batch SCENES=cake BATCH=$PWD/batch" "evaluate EVALUATE=$PWD/evaluate"; do
      # shellcheck disable=SC2086
      run clean_make -C "$root" $goal EXECUTOR="$executor"
      echo "$output"
      [ "$status" -eq 2 ]
      [ "${#lines[@]}" -eq 1 ]
      [[ $output = *"EXECUTOR=$executor is not there"*local* ]]
    done
  done
  [ -z "$(ls)" ]
  clean_make -C "$root" -n run SCENE="$PWD/scene.json" RUN="$PWD/run" EXECUTOR=local 2>&1 | grep -q "SCENE=$PWD/scene.json is not there"
}

# An executor that writes down its jobs, holds them against what they declare, and marks what they run; and tools that write down who ran
# them.
make_executor() {
  mkdir tools
  cat >mine.mk <<MK
job = '$PWD/job' '\$(1)' "\$(2)" '\$(3)' '\$(4)' '\$(5)'
job_threads = \$(if \$(filter simulate-%,\$(1)),2,1)
MK
  cat >job <<'SH'
#!/bin/bash
name=$1 threads=$2 inputs=$3 outputs=$4 log=$5
shift 5
here=$(dirname "$0")
for file in $inputs; do [ -e "$file" ] || echo "$name: input $file is not there" >>"$here/problems"; done
[ -d "$(dirname "$log")" ] || echo "$name: no folder for $log" >>"$here/problems"
[[ "$* " != *" --threads "* || "$* " = *" --threads $threads "* ]] || echo "$name: not $threads threads: $*" >>"$here/problems"
JOB=$name "$@"
status=$?
if [ $status -eq 0 ] || [ $status -eq 6 ]; then
  for file in $outputs; do [ -e "$file" ] || echo "$name: output $file is not there" >>"$here/problems"; done
fi
echo "$name" >>"$here/jobs"
exit $status
SH
  for tool in "$bin"/pm-*; do
    printf '#!/bin/bash\necho "${JOB:-nobody} %s $1" >>%q\nexec %q "$@"\n' "$(basename "$tool")" "$PWD/calls" "$tool" >"tools/$(basename "$tool")"
  done
  chmod +x job tools/*
}

@test "executors: one of my own gets every job of a run, a batch and an evaluation" {
  cd "$BATS_TEST_TMPDIR"
  make_executor
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out scene --quiet
  mine() { clean_make -f "$root/pipelines/installed.mk" BIN="$PWD/tools" EXECUTOR="$PWD/mine.mk" "$@"; }
  # A run of two rounds, then one that ends without an admissible candidate.
  mine run SCENE=scene/scene.json RUN=run SET="screening.initial=2 screening.tau=1.0"
  sort jobs >sorted
  diff - sorted <<'LIST'
camera0
camera1
candidates0
candidates1
ground
lift
material
render-hard-support-bonded
render-hard-support-bonded-role-balanced
render-posterior
report
screen0
screen1
simulate-hard-support-bonded
simulate-hard-support-bonded-role-balanced
simulate-posterior
spec
LIST
  run mine run SCENE=scene/scene.json RUN=run SET="screening.initial=2 screening.tau=9 screening.rounds=1"
  [ "$status" -ne 0 ]
  [[ $output = *"rank  candidate"* ]]
  grep -qx explain jobs
  mine batch SCENES=scene/scene.json BATCH=batch SET=screening.initial=2
  [ -s batch/scene/final.mp4 ]
  grep -qx table jobs

  mkdir suite
  cp "$root/tests/data/tiny.json" suite/good.json
  cat >suite/reference.json <<'JSON'
{"schema": "physmas/configuration/1", "settings": [],
 "rows": {"lollipop/candy": {"branch": "Jelly", "E": 1e5, "nu": 0.4, "rho": 1100}, "lollipop/stick": {"branch": "Metal", "E": 1e6, "nu": 0.3, "rho": 700}},
 "actions": []}
JSON
  cat >suite/suite.json <<'JSON'
{"schema": "physmas/suite/1", "settings": ["render.width=160", "render.height=160"],
 "methods": [{"id": "full", "name": "Full", "settings": ["screening.initial=2"]}],
 "comparison": ["full"], "required": ["trajectory_nrmse"],
 "cases": [{"id": "good", "kind": "multi-part", "example": "good.json", "reference": "reference.json", "objects": ["lollipop"]}]}
JSON
  "$bin/pm-eval" suite --suite suite/suite.json --register
  mine evaluate SUITE=suite/suite.json EVALUATE=evaluate
  grep -q '^done' evaluate/results/good/full/result.tsv
  for job in synth-good reference-good result-good-full collect aggregate; do grep -qx "$job" jobs; done

  if [ -e problems ]; then cat problems; return 1; fi
  # Hashes are checked while make reads its files; all else ran in a job, the tools in the scripts too.
  grep '^nobody' calls | sort -u >strays
  diff - strays <<<'nobody pm-eval suite'
  grep -q '^reference-good pm-simulate' calls
  grep -q '^result-good-full pm-eval motion' calls
}
