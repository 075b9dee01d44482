#!/usr/bin/env bats
# The tools against an independent recomputation from the paper's text (tests/golden), on generated records.
load common

setup() { cd "$BATS_TEST_TMPDIR"; }

@test "golden: evidence, candidates, repairs, scores and decisions are those of the paper" {
  run python3 "$root/tests/golden/run.py" "$bin" "${PM_TEST_BIN:-$bin/../test}/make_fixture" "$root/tests/data/stages" "$BATS_TEST_TMPDIR/work"
  echo "$output"
  [ "$status" -eq 0 ]
}

@test "golden: the worked example of docs/method.md is what the tools print" {
  python3 "$root/tests/golden/worked_example.py" "$bin" "${PM_TEST_BIN:-$bin/../test}/make_fixture" "$root/tests/data/stages" "$BATS_TEST_TMPDIR/work" >printed.md
  sed -n '/^<!-- worked example -->$/,/^<!-- end of the worked example -->$/p' "$root/docs/method.md" | sed '1d;$d' >written.md
  diff printed.md written.md
}
