#!/usr/bin/env bats
# pipelines/installed.mk: runs from any folder, outside the tree.
load common

setup_file() {
  share=$BATS_FILE_TMPDIR/prefix/share/physmas
  mkdir -p "$share"
  cp -r "$root/pipelines" "$root/examples" "$share"
  cp "$root/pipelines/installed.mk" "$share/physmas.mk"
}

setup() {
  prefix=$BATS_FILE_TMPDIR/prefix
  cd "$BATS_TEST_TMPDIR" || return 1
}

# BIN of the environment is another program's business.
outside() { env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL BIN=/nowhere make --no-print-directory -f "$prefix/share/physmas/physmas.mk" "$@"; }

@test "installed: a file becomes a video in runs/ of the folder that make is called in, with tools on PATH" {
  before=$(fingerprint "$prefix")
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle --quiet
  mv bundle/gaussians.ply thing.ply
  cat >spec.json <<'J'
{"schema": "physmas/run/1", "grid": {"n": 24}, "time": {"frames": 10, "substep_dt": 8e-4, "min_substep_dt": 2e-4, "max_substeps": 200}, "render": {"width": 320, "height": 320},
 "screening": {"initial": 2}}
J
  import() { PATH=$bin:$PATH outside run GAUSSIANS=thing.ply UP=z SPEC=spec.json PROMPT="the thing falls onto the floor"; }
  import >log
  grep -q '^Accepted' log
  [ -s runs/thing/final.mp4 ]
  import >log
  grep -q '^Nothing to do' log
  # Make goes on from a run alone, and a batch calls the same makefile.
  PATH=$bin:$PATH outside run RUN=runs/thing | grep -q '^Accepted\|^Nothing to do'
  PATH=$bin:$PATH outside batch SCENES=runs/thing/bundle/scene.json SET=screening.initial=1 >log
  [ -s runs/batch/thing/final.mp4 ]
  [ "$(fingerprint "$prefix")" = "$before" ]
}

@test "installed: examples and the registered benchmark are those beside it" {
  PATH=$bin:$PATH outside -n demo >log 2>&1
  grep -q "pm-scene synth $prefix/share/physmas/examples/cake.json --out runs/demo/bundle" log
  PATH=$bin:$PATH run outside evaluate CASES=cow
  [ "$status" -eq 2 ]
  [[ $output = *"found \"cow\", expected some of cake"* ]]
  [[ $output = *"$prefix/share/physmas/examples/suite.json was refused"* ]]
}

@test "installed: tools of the same prefix come before those on PATH, BIN= before both" {
  PATH=$bin:$PATH outside | grep -q "BIN=$bin\$"
  mkdir -p "$prefix/bin" other
  ln -s "$bin"/pm-* "$prefix/bin"
  ln -s "$bin"/pm-* other
  PATH=$bin:$PATH outside help | grep -q "BIN=$prefix/bin\$"
  outside BIN=other help | grep -q "BIN=other\$"
  # Through a link the file still finds what lies beside it.
  ln -s "$prefix/share/physmas/physmas.mk" mine.mk
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -f mine.mk -n demo | grep -q "^$prefix/bin/pm-scene synth $prefix/share"
  rm -r "$prefix/bin"
}

@test "installed: without tools it says what is missing" {
  if PATH=/usr/bin:/bin command -v pm-scene; then skip "tools are installed on this machine"; fi
  for arguments in help "help BIN=empty"; do
    # shellcheck disable=SC2086
    PATH=/usr/bin:/bin run outside $arguments
    echo "$output"
    [ "$status" -eq 2 ]
    [ "${#lines[@]}" -eq 1 ]
    [[ $output = *pm-scene*"BIN=folder"* ]]
  done
}

@test "installed: in the tree it works where it lies" {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -f "$root/pipelines/installed.mk" BIN="$bin" -n demo |
    grep -q "^$bin/pm-scene synth $root/examples/cake.json --out runs/demo/bundle"
  # It builds nothing: a tool that is gone is an error of the run.
  mkdir empty
  touch empty/pm-scene
  run env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -f "$root/pipelines/installed.mk" BIN=empty demo
  [ "$status" -ne 0 ]
  [[ $output = *"empty/pm-scene"* ]]
}
