#!/usr/bin/env bats
# What make does with its variables: every one counts or is refused by name, names may have spaces, and no run replaces
# another.
load common
load coarse

setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  make_coarse_scene
}

setup() {
  cd "$BATS_TEST_TMPDIR" || return 1
  cp -r "$BATS_FILE_TMPDIR"/{bundle,spec.json} .
}

# refuses TEXT... -- ARGUMENT...: one line with every TEXT, and no folder is made.
refuses() {
  local texts=() text
  while [ "$1" != -- ]; do texts+=("$1"); shift; done
  shift
  run run_make "$@"
  echo "$output"
  [ "$status" -eq 2 ] || return 1
  [ "${#lines[@]}" -eq 1 ] || return 1
  for text in "${texts[@]}"; do [[ $output = *"$text"* ]] || { echo "no $text"; return 1; }; done
  [ ! -e runs ] || return 1
}

@test "make: a variable that nobody knows is refused with the nearest name" {
  refuses INVENTROY "the nearest is INVENTORY" -- run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" INVENTROY=x.json
  refuses propmt "the nearest is PROMPT" -- run EXAMPLE=cake propmt="it falls"
  refuses "no variable XYZZY." -- run EXAMPLE=cake XYZZY=1
  refuses "no variable PROMPT" -- evaluate PROMPT="it falls"
  refuses "make batch has no variable RUN" -- batch SCENES=cake RUN=x
  refuses "no example" "the nearest is sunflower" -- run EXAMPLE=sunflowr
  refuses "no example" cake lamp -- run EXAMPLE=nothing-like-it
  # An executor's own variables are known.
  printf 'job =\njob_threads = 1\nEXECUTOR_VARIABLES := QUEUE\n' >mine.mk
  run_make -n run EXAMPLE=cake EXECUTOR=mine.mk QUEUE=long >/dev/null
  refuses "no variable QUEUE" -- run EXAMPLE=cake QUEUE=long
}

@test "make: what does not go together is refused by name" {
  refuses "DEVICE=tpu" "expected auto, cpu or cuda" -- run SCENE=bundle/scene.json DEVICE=tpu
  for variable in UP=z INVENTORY=spec.json OPACITY=0.1 AZIMUTH=3 MASKS=bundle; do
    refuses "${variable%%=*} goes with GAUSSIANS" "an example" -- run EXAMPLE=cake "$variable"
    refuses "${variable%%=*} goes with GAUSSIANS" "a bundle" -- run SCENE=bundle/scene.json "$variable"
  done
  refuses "EXAMPLE or SCENE, not both" -- run EXAMPLE=cake SCENE=bundle/scene.json
  refuses MODEL AGENT= -- run EXAMPLE=cake MODEL=x
  refuses "make demo runs an example" -- demo SCENE=bundle/scene.json
}

@test "make: files and folders that are not there, or not what they should be, are refused before a folder is made" {
  for variable in SPEC AUTHORED PREDICTOR BASE; do
    refuses "$variable=no/such.json is not there" -- run EXAMPLE=cake "$variable=no/such.json"
  done
  for variable in INVENTORY CAMERAS PHYSGAUSSIAN MATERIALS MASKS; do
    refuses "$variable=no such (1).json is not there" -- run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" "$variable=no such (1).json"
  done
  refuses "GAUSSIANS=my scans/x.ply is not there" -- run GAUSSIANS="my scans/x.ply" PROMPT="it falls"
  refuses "SCENE=bundle is a folder" -- run SCENE=bundle
  refuses "MASKS=spec.json is a file, expected a folder" -- run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" MASKS=spec.json
  refuses "RUN=my runs/a" spaces -- run EXAMPLE=cake RUN="my runs/a"
}

@test "make: PROMPT and SPEC change a bundle and an example; without them the scene's own count" {
  run_make run SCENE=bundle/scene.json RUN=a SPEC=spec.json SET=screening.initial=3 PROMPT='it isn'\''t $5, it is "pushed" to the left'
  grep -qF '"it isn'\''t $5, it is \"pushed\" to the left"' a/plan.json
  grep -q '"frames": 4' a/spec/simulate.json
  [ "$(find a/rollouts -name '*.h5' | wc -l)" -eq 3 ]
  cp a/candidates/posterior.json a/candidates/mine.json
  # An earlier run goes on from its folder alone. What belonged to the former list of candidates is gone.
  run_make run RUN=a SPEC=spec.json
  refute grep pushed a/plan.json
  [ "$(find a/rollouts -name '*.h5' | wc -l)" -eq 2 ]
  [ "$(find a/videos -name '*.json' | wc -l)" -eq 2 ]
  [ "$(find a/candidates -name '*.json' -not -name 'round*' | wc -l)" -eq 3 ]
  [ -e a/candidates/mine.json ]
  run_make run RUN=a SPEC=spec.json >log
  grep -q '^Nothing to do' log
  "$bin/pm-scene" slice --scene bundle/scene.json --prompt "it melts" --out spec
  grep -q '"prompt": "it melts"' spec/ground.json
  fails_with 3 "$bin/pm-scene" slice --scene bundle/scene.json --prompt "  " --out spec2 -- --prompt blank
  run_make -n run EXAMPLE=cake PROMPT=x SPEC=spec.json >log
  grep -qF -- '--prompt="$PM_ASKED_PROMPT" --overrides="$PM_ASKED_SPEC"' log
  run_make -n run EXAMPLE=cake MATERIAL="sponge=Rubber icing=Foam" >log
  grep -qF -- '--material="$PM_ASKED_MATERIAL"' log
}

@test "make: a file whose name has spaces and accents is run under a name of its own" {
  mkdir "my scans"
  cp bundle/gaussians.ply "my scans/Büro – Stuhl (1).ply"
  cp spec.json "my scans/a spec.json"
  import() { run_make run GAUSSIANS="my scans/Büro – Stuhl (1).ply" PROMPT="it falls" UP=z SPEC="my scans/a spec.json" "$@"; }
  import
  [ -s runs/B-ro-Stuhl-1/final.mp4 ]
  grep -q '"path": "Büro – Stuhl (1).ply"' runs/B-ro-Stuhl-1/bundle/scene.json
  import >log
  grep -q '^Nothing to do' log
  touch "my scans/Büro – Stuhl (1).ply"
  import >log
  grep -q '  import ' log
  cp -r bundle "my scans/b (2)"
  run_make run SCENE="my scans/b (2)/scene.json" RUN=c SPEC=spec.json DEVICE=cpu
  grep -q '"device_reason": "asked for"' c/rollouts/*.json
  [ -s c/final.mp4 ]
}

@test "make: another file does not replace a run of a file of the same name; a moved one is the same" {
  mkdir A B C
  cp bundle/gaussians.ply A/scan.ply
  cp bundle/gaussians.ply C/scan.ply
  { cat bundle/gaussians.ply; echo; } >B/scan.ply
  go() { run_make run GAUSSIANS="$1" PROMPT="it falls" UP=z SPEC=spec.json SET=screening.initial=1; }
  go A/scan.ply
  before=$(fingerprint runs)
  run go B/scan.ply
  echo "$output"
  [ "$status" -eq 2 ]
  [ "${#lines[@]}" -eq 1 ]
  [[ $output = *"runs/scan is the run of GAUSSIANS=$PWD/A/scan.ply"*RUN=* ]]
  [ "$(fingerprint runs)" = "$before" ]
  rm A/scan.ply
  run go C/scan.ply
  [ "$status" -eq 0 ]
}

@test "make: -n changes nothing" {
  for goal in "run EXAMPLE=cake" "run SCENE=bundle/scene.json RUN=a" "demo" "batch SCENES=cake" "evaluate"; do
    # shellcheck disable=SC2086
    run_make -n $goal >/dev/null
  done
  [ "$(ls)" = "$(printf 'bundle\nspec.json')" ]
}

@test "make: where a tool refuses its input, that is said, and no file of make's own is missing" {
  sed -i 's/"fx"/"focal"/' bundle/scene.json
  run run_make run SCENE=bundle/scene.json RUN=a
  echo "$output"
  [ "$status" -eq 2 ]
  [[ $output = *"pm-scene: error: bundle/scene.json"* ]]
  [[ $output != *"No such file"* && $output != *"No rule"* ]]
}

@test "make: a PATH without the ordinary programs is named, before anything is made" {
  run env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL PATH="$BATS_TEST_TMPDIR" /usr/bin/make -f "$root/pipelines/installed.mk" BIN="$bin" run GAUSSIANS=x.ply RUN=runs/x
  [ "$status" -eq 2 ]
  [[ "$output" == *"mkdir"*"not found on PATH"* ]]
  [ "${#lines[@]}" -eq 1 ]
  [ ! -e runs ]
}
