# docs/equations.md: every labelled equation and table of the paper leads to code that is there and cites it.
load common

@test "equations: files and symbols exist, code and page cite the same labels" {
  python3 "$root/tests/check-equations.py" "$root"
}

# A tree of one equation, for what the check must find.
setup() {
  cd "$BATS_TEST_TMPDIR"
  mkdir -p docs lib/a tools
  printf '%s\n' 'The paper (1 equations, 0 tables, 0 algorithms).' '| `eq:one` | x | [`lib/a/one.h`](../lib/a/one.h): `first`, `kSecond` |' >docs/equations.md
  printf '%s\n' '// Adds (paper, Eqs.' '// one, two).' 'int first(int kSecond);' >lib/a/one.h
}

# The check prints exactly this line.
finds() { # LINE
  run python3 "$root/tests/check-equations.py" .
  echo "$output"
  [ "$status" -eq 1 ]
  [ "$output" = "$1" ]
}

@test "equations: a label that only the code has is found, also where a comment is broken" {
  finds 'lib/a/one.h: cites eq:two, which is not on the page'
}

@test "equations: what the code does not have, or does not cite, is found" {
  sed -i 's/, two//; s/kSecond/second/' lib/a/one.h
  finds 'eq:one: no kSecond in lib/a/one.h'
  sed -i 's/second/kSecond/; s/Eqs[.]/as/' lib/a/one.h
  finds 'eq:one: none of its files cites it'
  rm lib/a/one.h
  finds $'eq:one: no file lib/a/one.h\neq:one: none of its files cites it'
}

@test "equations: a row that is gone is found" {
  sed -i 's/, two//' lib/a/one.h
  python3 "$root/tests/check-equations.py" .
  sed -i 's/(1 equations/(2 equations/' docs/equations.md
  finds '1 rows of eq:, where the paper has 2'
}
