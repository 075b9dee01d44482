#!/usr/bin/env bats
# The tests of this folder themselves: no line whose failure goes unnoticed (tests/tools/vacuous.py), and refute does its work.
load common

vacuous() { python3 "$root/tests/tools/vacuous.py" "$@"; }

@test "assertions: none in this folder is vacuous" {
  vacuous "$root"/tests/cli/*.bats "$root"/tests/cli/*.bash
}

@test "assertions: every form that bats ignores is found, with its line" {
  cd "$BATS_TEST_TMPDIR"
  cat >planted.bats <<'PLANTED'
setup() { # 1
  ! grep -q a file
  if true; then ! [ -e file ]; fi
  for f in a b; do ! cmp $f file; done
  (! grep -q a file)
  [ -e a ] || ! [ -e b ]
  helper() { ! grep -q "$1" file; }
  [ -e a ] && [ -e b ]
  cd a &&
    [[ $x = "&& b" ]]
  grep -q a file || true
  diff a b | head -3
  grep a file | wc -l
  run helper a
  run helper b
  [ "$status" -eq 0 ]
  run helper c
} # 18
PLANTED
  run vacuous planted.bats
  echo "$output"
  [ "$status" -eq 1 ]
  [ "$(grep -oE '^planted.bats:[0-9]+' <<<"$output" | cut -d: -f2 | tr '\n' ' ')" = "2 3 4 5 6 7 8 9 11 12 13 14 17 " ]
}

@test "assertions: what bats notices is not complained of" {
  cd "$BATS_TEST_TMPDIR"
  cat >sound.bats <<'SOUND'
setup() {
  refute grep a file # ! grep && nothing
  if ! grep -q a file; then echo '! cmp && cmp'; fi
  until [ -e a ] && [ -e b ]; do sleep 1; done
  for i in 1 2 3; do [ -s a ] && break; done
  [ ! -e a ] || [ ! -e b ]
  [ -e a ] || { echo "none"; return 1; }
  [[ $a = x && $b != y ]]
  [ "$(cd a && ! ls | wc -l)" -eq 1 ]
  grep -A2 a file | grep -q b
  grep a file | sort >sorted
  kill "$server" || true
  run -3 helper a
  run helper b
  [[ $output = *"a"* ]]
  cat <<'TEXT'
! grep a file
run helper
TEXT
}
SOUND
  sed -i 's/ && false//' sound.bats
  vacuous sound.bats
}

@test "assertions: refute wants the answer no, not a failure" {
  cd "$BATS_TEST_TMPDIR"
  echo a >file
  refute grep b file
  refute cmp file /dev/null
  run refute grep a file
  [ "$status" -eq 1 ]
  [[ $output = *"exit code 0, expected 1: grep a file" ]]
  run refute grep -q b missing
  [ "$status" -eq 1 ]
  [[ $output = *"exit code 2, expected 1"* ]]
}
