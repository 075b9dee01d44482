#!/usr/bin/env bats
# What a user gives make is text: whatever a variable, a list of scenes or the name of a file holds, nothing of it is run. What
# make cannot hold is refused in one line, and nothing is changed. INJECTIONS=all tries every text on every variable.
load common

# Texts that run `touch canary` where make, a shell or xargs reads them, and those that break a quote, a word or a line.
payloads=(
  '$(shell touch canary)'
  ';touch canary;`touch canary`$(touch canary)'
  '"'\'';touch canary;#'
  $'a\ntouch canary\n'
  '-x $$(touch canary) ${PWD}'
  '$(info canary)$(error canary)'
  '"|touch canary&&touch canary||'
  '$(eval $(shell touch canary))'
  '$$(shell touch canary) $(1) $@ $<'
  '>canary'
  '*?[a-z]{a,b}~'
  '--help'
  '\'
  '%:=#'
)
some=("${payloads[0]}" "${payloads[1]}" "${payloads[2]}" "${payloads[3]}" "${payloads[4]}")
if [ "${INJECTIONS:-}" = all ]; then some=("${payloads[@]}"); fi

run_make() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" "$@"; }

# A finished run, and tools that only write down what they are given: in a copy of it, every stage's recipe runs and does nothing.
setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle --quiet
  cat >spec.json <<'J'
{"schema": "physmas/run/1", "time": {"frames": 4}, "screening": {"initial": 1, "rounds": 1, "tau": -9}, "render": {"width": 64, "height": 64}}
J
  run_make BIN="$bin" run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" UP=z RUN=run SPEC=spec.json DEFAULTS= 2>/dev/null
  mkdir tools
  for tool in "$bin"/pm-*; do
    printf '#!/bin/bash\nprintf "%%s\\n" "$@" >>%q\n' "$PWD/arguments" >"tools/$(basename "$tool")"
  done
  chmod +x tools/*
}

# For the table of `make hardening`.
teardown_file() { echo "# tried $(wc -l <"$BATS_FILE_TMPDIR/tried") texts" >&3; }

setup() {
  cd "$BATS_TEST_TMPDIR" || return 1
  cp -a "$BATS_FILE_TMPDIR"/{bundle,spec.json,run} .
  tools=$BATS_FILE_TMPDIR/tools arguments=$BATS_FILE_TMPDIR/arguments
}

# The state of the working folder, without what make notes about its own work.
state() { find . -path ./run/.stamps -prune -o -printf '%p %s %T@\n' | sort; }

# tries OUTCOME VARIABLE TEXT ARGUMENT...: make with these arguments, of which VARIABLE holds TEXT. `refused`: in one line, and nothing
# is changed; `taken`: TEXT reached a tool, as a whole; `safe`: either; `unrun`:
# nothing of it was run.
tries() {
  local outcome=$1 variable=$2 text=$3
  shift 3
  rm -f "$arguments"
  echo >>"$BATS_FILE_TMPDIR/tried"
  local before status=0
  before=$(state)
  run_make BIN="$tools" "$@" >"$BATS_TEST_TMPDIR/../output" 2>&1 || status=$?
  [ ! -e canary ] && [ -z "$(find "$root" -maxdepth 1 -name canary)" ] || { echo "$variable=$text was run"; return 1; }
  if [ "$outcome" = unrun ]; then return; fi
  if [ "$status" -ne 0 ] && [ "$outcome" != taken ]; then
    [ "$(grep -c . "$BATS_TEST_TMPDIR/../output")" -eq 1 ] || { cat "$BATS_TEST_TMPDIR/../output"; echo "$variable=$text: not one line"; return 1; }
    [ "$(state)" = "$before" ] || { diff <(state) <(echo "$before"); echo "$variable=$text: refused, but files changed"; return 1; }
  elif [ "$outcome" = refused ] || [ "$status" -ne 0 ]; then
    cat "$BATS_TEST_TMPDIR/../output"; echo "$variable=$text: exit code $status, expected $outcome"; return 1
  elif [ "$outcome" = taken ]; then
    TEXT=$text python3 -c 'import os, sys; t = open(sys.argv[1]).read(); sys.exit(os.environ["TEXT"] not in t)' "$arguments" ||
      { cat "$arguments"; echo "$variable=$text did not arrive"; return 1; }
  fi
}

# taken_by VARIABLE TEXT: what is right; a user's name in what may be a URL is none of these texts' business.
taken_by() {
  case $1:$2 in
    AGENT:*@* | SCENE_AGENT:*@* | PERCEPTION:*@* | PREDICTOR:*@*) echo refused ;;
    *) echo taken ;;
  esac
}

scene=(run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" UP=z RUN=run SPEC=spec.json DEFAULTS=)

@test "injection: texts arrive at the tools as they are" {
  for text in "${some[@]}"; do
    tries taken PROMPT "$text" "${scene[@]}" PROMPT="$text"
    # A line's end is no part of anything else.
    [[ $text != *$'\n'* ]] || continue
    for variable in UP FRONT OPACITY DROP AZIMUTH ELEVATION MATERIAL AGENT SCENE_AGENT PERCEPTION; do
      tries "$(taken_by $variable "$text")" $variable "$text" "${scene[@]}" "$variable=$text"
    done
    tries taken MODEL "$text" "${scene[@]}" AGENT=builtin MODEL="$text"
    # Words of these are settings, and each arrives.
    for variable in SET DEFAULTS CAMERA; do
      tries taken $variable "${text##* }" "${scene[@]}" "$variable=$text"
    done
  done
}

@test "injection: what stands in rules and commands is refused" {
  for text in "${some[@]}"; do
    for variable in RUN BASE THREADS EXECUTOR BIN EXAMPLE BUILD CXX V; do
      tries refused $variable "$text" "${scene[@]}" "$variable=$text"
    done
    tries refused CROP "$text --" "${scene[@]}" CROP="$text --"
    for variable in TIMEOUT BUDGET RETRIES; do tries refused $variable "$text" "${scene[@]}" AGENT=builtin "$variable=$text"; done
    for variable in EVALUATE SUITE CASES; do tries refused $variable "$text" evaluate "$variable=$text"; done
    tries refused BATCH "$text" batch SCENES=bundle/scene.json BATCH="$text"
    tries refused SCENES "$text" batch SCENES="$text"
  done
  tries refused THREADS 1e3 "${scene[@]}" THREADS=1e3
  for name in SHELL .SHELLFLAGS MAKEFLAGS MAKE; do tries refused $name x "${scene[@]}" $name=x; done
}

@test "injection: names of files and folders" {
  for text in "${some[@]}"; do
    [[ $text != */* && $text != *$'\n'* ]] || continue
    cp bundle/gaussians.ply -- "./$text.ply"
    cp spec.json "./$text"
    cp -r bundle "./$text.d"
    tries safe GAUSSIANS "$text" run GAUSSIANS="$text.ply" PROMPT="it falls" RUN=run
    tries taken SPEC "$text" "${scene[@]}" SPEC="$text"
    for variable in INVENTORY DATAPARSER PHYSGAUSSIAN MATERIALS AUTHORED PREDICTOR CAMERAS; do
      tries "$(taken_by $variable "$text")" $variable "$text" "${scene[@]}" "$variable=$text"
    done
    for variable in HEADERS BODY; do tries taken $variable "$text" "${scene[@]}" AGENT=builtin "$variable=$text"; done
    for variable in MASKS VIEWS; do tries taken $variable "$text" "${scene[@]}" "$variable=$text.d"; done
    for variable in AGENT SCENE_AGENT PERCEPTION PREDICTOR; do tries taken $variable "$text" "${scene[@]}" "$variable=replay:$text.d"; done
    tries unrun SCENE "$text" run SCENE="$text.d/scene.json" RUN=run2
    rm -rf run2
    # Files that are not there.
    for variable in GAUSSIANS SPEC MASKS VIEWS; do tries refused $variable "$text" "${scene[@]}" "$variable=no $text"; done
  done
}

@test "injection: the environment is no other way in" {
  for text in "${some[@]}"; do
    for variable in PROMPT MATERIAL SET; do
      (export "$variable=$text"; tries safe $variable "$text" run GAUSSIANS=bundle/gaussians.ply UP=z RUN=run SPEC=spec.json DEFAULTS=)
    done
    for variable in RUN THREADS BASE; do
      (export "$variable=$text"; tries refused $variable "$text" run GAUSSIANS=bundle/gaussians.ply PROMPT=x)
    done
  done
}

@test "injection: a batch's list holds scenes and values, and nothing that make obeys" {
  for line in 'run --eval=$(shell\ touch\ canary)' '-f evil.mk' 'PROMPT:=$(shell\ touch\ canary)' 'PROMPT!=touch\ canary' 'SHELL=./evil' 'RUN=elsewhere' \
    'BIN=.' 'EXECUTOR=evil.mk' 'THREADS+=1' 'AGENT=http://me:hunter2@localhost/v1' 'clean' 'PROMPT'; do
    echo "bundle/scene.json $line" >list.txt
    tries refused list "$line" batch SCENES=list.txt
    refute grep -rq hunter2 --exclude=list.txt . "$BATS_TEST_TMPDIR/../output"
  done
  # Values arrive at the tools as they are.
  for text in '$(shell touch canary)' ';touch canary;`touch canary`' '$$(touch canary) "it"' '%:=#'; do
    printf "%s 'PROMPT=%s'\n" bundle/scene.json "${text//#/}" >list.txt
    tries unrun PROMPT "$text" batch SCENES=list.txt BATCH=batch
    grep -qxF -- "--prompt=${text//#/}" "$arguments"
    rm -rf batch
  done
  tries unrun PROMPT '$(shell touch canary)' batch SCENES=bundle/scene.json BATCH=batch PROMPT='$(shell touch canary)'
  grep -qxF -- '--prompt=$(shell touch canary)' "$arguments"
}

@test "injection: the files of a bundle and of a run are data" {
  # The tree's Makefile expands what a rule waits for a second time.
  in_tree() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -C "$root" SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" "$@"; }
  touch 'bundle/$(shell touch canary).png' 'bundle/a b;touch canary.png' 'bundle/$$(shell touch canary).png'
  in_tree run SCENE="$PWD/bundle/scene.json" RUN="$PWD/run2" SPEC="$PWD/spec.json" SET=screening.initial=2 DEFAULTS= 2>/dev/null >log
  grep -q '^Accepted' log
  touch 'run/bundle/$(shell touch canary).png' 'run/bundle/views/$(error canary).png'
  in_tree run GAUSSIANS="$PWD/bundle/gaussians.ply" PROMPT="it falls" UP=z RUN="$PWD/run" SPEC="$PWD/spec.json" DEFAULTS= 2>/dev/null >log
  # Lines that tools wrote for make, in a run that somebody else may have made.
  for file in candidates/round0.mk screen/round0.mk .stamps/phase1.mk .stamps/phase2.mk .stamps/bundle.files .stamps/ids spec/camera.mk; do
    cp -a run2 hostile
    { if [ -e "hostile/$file" ]; then cat "hostile/$file"; fi; echo '$(shell touch canary)'; echo '../../spec'; } >edited
    cp edited "hostile/$file"
    touch -d 2000-01-01 "hostile/$file"
    in_tree run SCENE="$PWD/bundle/scene.json" RUN="$PWD/hostile" SPEC="$PWD/spec.json" SET=screening.initial=2 DEFAULTS= >log 2>&1 || true
    [ ! -e canary ] && [ ! -e "$root/canary" ] || { echo "$file was run"; return 1; }
    [ -e spec.json ]
    rm -rf hostile
  done
}

@test "injection: make clean and make install" {
  in_tree() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -C "$root" "$@"; }
  for text in "${some[@]}"; do
    for variable in BUILD STABILITY EVALUATE SECONDS FUZZ ACCURACY; do
      # What is wrongly taken must not remove this tree's build.
      run in_tree clean BUILD="$PWD/none" "$variable=$text"
      [ "$status" -eq 2 ] || { echo "$variable=$text"; return 1; }
    done
  done
  mkdir -p "other build/obj" other/obj other/mine
  run in_tree clean BUILD="$PWD/other build"
  [ "$status" -eq 2 ]
  in_tree clean BUILD="$PWD/other"
  [ ! -e other/obj ]
  for folder in other/mine "other build/obj" "$root/build"; do [ -d "$folder" ]; done
  in_tree install BUILD="$(dirname "$bin")" SAN="${PM_SAN:-0}" DESTDIR="$PWD/a b;touch canary" PREFIX='/$(shell touch canary)' >log
  [ -x "a b;touch canary/\$(shell touch canary)/bin/pm-scene" ]
  [ ! -e canary ]
  [ ! -e "$root/canary" ]
  in_tree uninstall DESTDIR="$PWD/a b;touch canary" PREFIX='/$(shell touch canary)'
  [ -z "$(find "a b;touch canary" -type f)" ]
}
