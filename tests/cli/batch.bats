#!/usr/bin/env bats
# make batch: many scenes, one table; a scene that fails stops no other.
load common

setup_file() {
  cd "$BATS_FILE_TMPDIR"
  for name in good broken strict; do "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out "$name" --quiet; done
  sed -i 's/"fx"/"focal"/' broken/scene.json
}

run_batch() {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" --no-print-directory SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" \
    batch BATCH="$BATS_FILE_TMPDIR/batch" "$@"
}

column() { awk -F '\t' -v row="$1" -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i } $1 == row { print $c }' "$BATS_FILE_TMPDIR/batch/table.tsv"; }

@test "batch: accepted, refused and broken scenes in one table" {
  cd "$BATS_FILE_TMPDIR"
  cat >list.txt <<LIST
# three scenes
$PWD/good/scene.json
$PWD/broken/scene.json
$PWD/strict/scene.json "SET=screening.tau=9 screening.rounds=1"   # nothing can be admitted
LIST
  run run_batch -j2 SCENES="$PWD/list.txt"
  echo "$output"
  [ "$status" -eq 0 ]
  [ "$(wc -l <batch/table.tsv)" -eq 4 ]
  [ "$(column good result)" = accepted ]
  [ -n "$(column good candidate)" ]
  [ "$(column good candidate)" != - ]
  [ "$(column good rounds)" = 1 ]
  [ -s batch/good/final.mp4 ]
  [ "$(column broken result)" = failed ]
  [[ $(column broken reason) = *scene.json* ]]
  [ "$(column strict result)" = "none admitted" ]
  [[ $(column strict reason) = *"tau 9"* ]]
  # Times are there, and a second call computes nothing again.
  [ "$(column good simulate_s)" != 0.00 ]
  before=$(stat -c %y batch/good/final.mp4)
  run_batch SCENES="$PWD/list.txt" >second.log
  [ "$(stat -c %y batch/good/final.mp4)" = "$before" ]
  grep -q "2 of 3 scenes are up to date" second.log
  [ "$(column good result)" = accepted ]
}

@test "batch: mistakes are explained" {
  run run_batch SCENES="cake cake"
  [ "$status" -ne 0 ]
  [[ $output = *"two scenes are called cake"* ]]
  run run_batch
  [ "$status" -ne 0 ]
  [[ $output = *SCENES* ]]
}

@test "batch: a name is an id, and each run has its own scene's variables" {
  cd "$BATS_TEST_TMPDIR"
  mkdir -p scenes x batch
  for name in a.b axb 1 1.0; do
    cp -r "$BATS_FILE_TMPDIR/good" "scenes/$name"
    printf '%s "PROMPT=the lollipop of %s falls"\n' "$PWD/scenes/$name/scene.json" "$name" >>list.txt
  done
  run_batch BATCH="$PWD/batch" SCENES="$PWD/list.txt" SET="screening.rounds=1 screening.initial=1 time.frames=2" >log
  for name in a.b axb 1 1.0; do grep -qF "the lollipop of $name falls" "batch/$name/plan.json" || { echo "$name"; return 1; }; done
  # Neither a folder above nor a file of the batch's own.
  names_of() { EXAMPLES=$root/examples/ bash "$root/pipelines/batch-scenes.sh" /dev/null "$1" "PROMPT"; }
  [ "$(cd scenes && names_of "../x/../scene.json")" = "$(basename "$PWD")" ]
  [ "$(names_of "x/../../../../../../../../../../../scene.json")" = scene ]
  [ "$(names_of "x/table.tsv/scene.json ..a../scene.json -r/scene.json")" = "table-tsv a r" ]
}

@test "batch: files of any ending, and names that are neither an example nor a file" {
  cd "$BATS_TEST_TMPDIR"
  mkdir "my scans"
  touch "my scans/a (1).ply"
  # A dot in a name is a dot.
  printf '%s\n' '"my scans/a (1).ply" PROMPT=one' 'v3.spz PROMPT=two' 'a.b/scene.json PROMPT=three' 'axb.ply PROMPT=four' 'cake PROMPT=five' >list.txt
  names=$(EXAMPLES=$root/examples/ bash "$root/pipelines/batch-scenes.sh" list list.txt "PROMPT UP")
  [ "$names" = "a-1 v3 a.b axb cake" ]
  grep -q $'^v3\tGAUSSIANS=v3.spz\tPROMPT=two$' list
  grep -q $'\tGAUSSIANS=my scans/a (1).ply\tPROMPT=one$' list
  grep -q $'^cake\tEXAMPLE=cake\tPROMPT=five$' list
  run run_batch SCENES="cake sunflowr"
  [ "$status" -ne 0 ]
  [[ $output = *"sunflowr is no example and no file"* ]]
}

@test "batch: 500 scenes with nothing to do say so within two seconds, and what changed is found" {
  cd "$BATS_TEST_TMPDIR"
  cp -r "$BATS_FILE_TMPDIR/good" proto
  run_installed() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$bin" batch BATCH=batch SET="screening.rounds=1 screening.initial=2 screening.tau=-9 time.frames=2" "$@"; }
  run_installed SCENES=proto/scene.json >log 2>&1
  # Copies with the same times, as if each had been run.
  for i in {1..500}; do
    cp -a proto "s$i"
    cp -a batch/proto "batch/s$i"
    sed -i "s#/proto\([/.]\|\$\)#/s$i\1#" "batch/s$i/source"
    sed "s#/proto\t#/s$i\t#; s#/proto/#/s$i/#; s#\tproto\t#\ts$i\t#; s#\tproto\$#\ts$i#; s#proto/scene.json#s$i/scene.json#; s#/proto\$#/s$i#" batch/proto/.stamps/settled >"batch/s$i/.stamps/settled"
    # Its own files have other times than those of the copy that sed wrote.
    file=$(stat -c '%s' "batch/s$i/source") time=$(find "batch/s$i/source" -printf '%T@')
    sed -i "s#^file\ts$i\tsource\t.*#file\ts$i\tsource\t$file\t$time#" "batch/s$i/.stamps/settled"
    echo "s$i/scene.json"
  done >list.txt
  run_installed SCENES=list.txt >log 2>&1
  grep -q '^Nothing to do: 500 of 500 scenes are up to date' log
  [ "$(wc -l <batch/table.tsv)" -eq 501 ]
  # Processor time, since other tests may run beside it.
  TIMEFORMAT='%U %S'
  { time run_installed SCENES=list.txt >log 2>&1; } 2>spent
  grep -q '^Nothing to do: 500 of 500' log
  cat spent
  awk '{ exit !($1 + $2 < 2) }' spent
  # A file of a run, one of a source, and what is asked for.
  touch batch/s7/candidates/round0.json
  touch s9/gaussians.ply
  rm batch/s11/final.mp4
  sed -i 's#^s13/scene.json#& "SET=screening.rounds=1 screening.initial=2 screening.tau=9 time.frames=2"#' list.txt
  run_installed SCENES=list.txt >log 2>&1
  grep -q '^496 of 500 scenes are up to date' log
  [ "$(grep -cE 'batch/s(7|9|11)$' log)" -eq 3 ]
  [ -s batch/s11/final.mp4 ]
  grep -q '^s13	none admitted' batch/table.tsv
}

@test "batch: no scene is in its second round before all have ended their first" {
  cd "$BATS_TEST_TMPDIR"
  mkdir tools
  for tool in "$bin"/pm-*; do
    printf '#!/bin/bash\necho "%s $*" >>%q\nexec %q "$@"\n' "${tool##*/}" "$PWD/calls" "$tool" >"tools/${tool##*/}"
  done
  chmod +x tools/*
  cp -r "$BATS_FILE_TMPDIR/good" one
  cp -r "$BATS_FILE_TMPDIR/good" two
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$PWD/tools" batch SCENES="one/scene.json two/scene.json" BATCH=batch \
    SET="screening.initial=1 screening.repairs=1 screening.rounds=2 screening.tau=9 time.frames=2" >log 2>&1
  cat log
  [ "$(grep -c 'pm-candidates .*--repair' calls)" -eq 2 ]
  last=$(grep -n 'pm-screen .*--round 0' calls | tail -n 1 | cut -d: -f1)
  first=$(grep -n 'pm-candidates .*--repair' calls | head -n 1 | cut -d: -f1)
  [ "$last" -lt "$first" ]
  grep -q '^two	none admitted	-	2	' batch/table.tsv
}

@test "batch: a scene whose variables do not go is a row, and stops no other" {
  cd "$BATS_TEST_TMPDIR"
  for name in one two three four; do cp -r "$BATS_FILE_TMPDIR/good" $name; done
  cat >list.txt <<LIST
$PWD/one/scene.json SPEC=nowhere.json
$PWD/two/scene.json UP=z
$PWD/three/scene.json THREADS=x
$PWD/four/scene.json "SET=screening.initial=2 screening.rounds=1 screening.tau=-9 time.frames=2"
LIST
  run_batch BATCH="$PWD/batch" SCENES="$PWD/list.txt" >log 2>&1
  cat log
  grep -q '^one	failed	.*error: SPEC=nowhere.json is not there$' batch/table.tsv
  grep -q '^two	failed	.*error: UP goes with GAUSSIANS=file: a bundle has its own; PROMPT, SPEC and SET change a run of it$' batch/table.tsv
  grep -q '^three	failed	.*error: THREADS=x: expected a number$' batch/table.tsv
  grep -q '^four	accepted	' batch/table.tsv
}

@test "batch: nodes whose processors differ in width are named" {
  cd "$BATS_TEST_TMPDIR"
  mkdir -p batch/{.live,a/.stamps}
  echo a | tee batch/.live/scenes >batch/.live/to-do
  echo 'n1 avx512 3' >batch/a/.stamps/simulate-soft.ran
  echo 'n2 avx512 3' >batch/a/.stamps/render-soft.ran
  BIN=$bin run bash "$root/pipelines/batch-table.sh" batch
  [ "$status" -eq 0 ]
  [[ $output != *width* ]]
  echo 'n3 avx2 3' >batch/a/.stamps/render-hard.ran
  BIN=$bin run bash "$root/pipelines/batch-table.sh" batch
  [[ $output = *"differ in width (avx2 on n3, avx512 on n1, avx512 on n2): the last digits of their results may differ"*PM_KERNELS* ]]
}

@test "batch: Ctrl-C and SIGTERM end the tools as well, and no scene has failed by that" {
  cd "$BATS_TEST_TMPDIR"
  mkdir tools
  for tool in "$bin"/pm-*; do ln -s "$tool" tools/; done
  rm tools/pm-lift
  printf '#!/bin/bash\necho $$ >%q\nexec sleep 30\n' "$PWD/sleeper" >tools/pm-lift
  chmod +x tools/pm-lift
  cp -r "$BATS_FILE_TMPDIR/good" one
  for signal in INT TERM; do
    rm -f sleeper
    # A session of its own, whose processes do not ignore SIGINT.
    python3 -c 'import os, signal, sys; os.setsid(); signal.signal(signal.SIGINT, signal.SIG_DFL); os.execvp(sys.argv[1], sys.argv[1:])' \
      env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$PWD/tools" batch SCENES=one/scene.json BATCH=batch >log 2>&1 3>&- &
    make=$!
    for _ in {1..100}; do [ ! -s sleeper ] || break; sleep 0.1; done
    if [ $signal = INT ]; then kill -INT -- -$make; else kill -TERM $make; fi
    status=0
    wait $make || status=$?
    [ "$status" -ne 0 ]
    for _ in {1..50}; do [ -d "/proc/$(<sleeper)" ] || break; sleep 0.1; done
    [ ! -d "/proc/$(<sleeper)" ]
    [ ! -e batch/one/batch.status ]
  done
}
