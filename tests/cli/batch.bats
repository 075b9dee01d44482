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
