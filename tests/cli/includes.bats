#!/usr/bin/env bats
# The arrows between the rooms of lib/, and tests/unit as their mirror (tests/check-includes.py).
bats_require_minimum_version 1.5.0
load common

setup() { cd "$BATS_TEST_TMPDIR" || return 1; }

# A tree of one file per room, with tests: nothing is wrong with it.
tree() {
  local room
  for room in base records scene splat lift screen bind mpm mpm/math mpm/cpu; do
    mkdir -p "lib/$room" "tests/unit/$room"
    touch "lib/$room/a.cpp" "tests/unit/$room/a.cpp"
  done
  mkdir -p tools
  touch tools/pm-a.cpp
}
check() { "$root/tests/check-includes.py" .; }

# One include in a file breaks a rule: the only line of output names both and holds the last argument.
refuses() { # FILE INCLUDED TEXT
  tree
  printf '#pragma once\n  #  include "%s"\n' "$2" >"$1"
  run -1 check
  echo "$output"
  [ "${#lines[@]}" -eq 1 ]
  [[ "$output" == "$1:2: found #include \"$2\"; "*"$3"* ]]
}

@test "includes: every include of this tree follows the arrows, and tests/unit mirrors lib" {
  run -0 "$root/tests/check-includes.py"
  [ -z "$output" ]
}

@test "includes: a tree that follows the arrows passes" {
  tree
  printf '#include "base/a.h"\n#include "records/a.h"\n#include <vector>\n' >lib/scene/a.cpp
  printf '#include "mpm/a.h"\n#include "screen/a.h"\n' >lib/bind/a.cpp
  printf '#include "bind/a.h"\n#include "mpm/a.h"\n' >tools/pm-a.cpp
  printf '#include "mpm/math/a.h"\n' >lib/splat/a.cpp
  printf '#include "mpm/math/a.h"\n#include "mpm/state.h"\n#include "base/a.h"\n' >lib/mpm/cpu/a.cpp
  run -0 check
  [ -z "$output" ]
}

@test "includes: against the arrows" { refuses lib/records/a.cpp scene/a.h "records/ includes base, records only"; }
@test "includes: from stage to stage" { refuses lib/screen/a.cpp lift/a.h "screen/ includes base, bundle, records, remote, scene, screen, splat only"; }
@test "includes: the solver from a stage" { refuses lib/lift/a.h mpm/a.h "lift/ includes"; }
@test "includes: the solver's kernels from the renderer" { refuses lib/splat/a.h mpm/cpu/a.h "splat/ includes"; }
@test "includes: records from the solver" { refuses lib/mpm/math/a.h records/a.h "mpm/ includes base, mpm only"; }
@test "includes: a back end from the solver's algebra" { refuses lib/mpm/math/a.h mpm/cpu/a.h "mpm/math/ includes base, mpm/math only"; }
@test "includes: a stage from binding's other side" { refuses lib/bind/a.cpp studies/a.h "bind/ includes"; }
@test "includes: a file beside, without its room" { refuses lib/lift/a.cpp a.h 'expected a path from lib/, such as "lift/a.h"'; }
@test "includes: a way up" { refuses lib/lift/a.cpp ../base/a.h "expected a path from lib/"; }
@test "includes: a room without a place" {
  tree
  mkdir -p lib/attic tests/unit/attic
  touch tests/unit/attic/a.cpp
  echo '#include "base/a.h"' >lib/attic/a.cpp
  run -1 check
  [[ "$output" == *"lib/attic/a.cpp:1:"*"lib/attic has no place in the order of rooms"* ]]
}

@test "includes: tests of a room that is not there, and a room without tests" {
  tree
  mkdir -p tests/unit/eval lib/plan
  touch tests/unit/eval/a.cpp lib/plan/a.cpp
  run -1 check
  [ "${lines[0]}" = "tests/unit/eval:1: lib/eval does not exist; expected the folders of lib/" ]
  [ "${lines[1]}" = "lib/plan:1: expected unit tests in tests/unit/plan" ]
}
