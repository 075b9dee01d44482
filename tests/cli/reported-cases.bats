#!/usr/bin/env bats
# Files after public reports about other tools, where they are: beside the project in ../shared/cases. They are not part of it; the
# same kinds of files are made in foreign-files.bats, pm-scene-formats.bats and the unit tests of lib/scene and lib/bundle.
bats_require_minimum_version 1.5.0
load common

cases=$root/../shared/cases

setup() {
  [ -d "$cases/right" ] || skip "no ../shared/cases"
  cd "$BATS_TEST_TMPDIR" || return 1
}

hold() { # KIND
  python3 "$root/tests/cli/reported_cases.py" "$bin/pm-scene" "$cases" "$BATS_TEST_TMPDIR" "$1"
}

@test "reported cases: every file of Gaussians holds and shows what it should, or is refused by name" { hold gaussians; }

@test "reported cases: every capture's cameras stand where they should, or are refused by name" { hold cameras; }

@test "reported cases: every PhysGaussian configuration is taken or refused as it should" { hold configurations; }
