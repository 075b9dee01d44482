# Shared by the tests of pm-material, pm-candidates and pm-screen: a small cake scene made with build/test/make_fixture.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bin=${PM_BIN:-$root/build/bin}
# Fixtures come from the same build as the tools.
make_fixture=${PM_TEST_BIN:-$bin/../test}/make_fixture
data=$root/tests/data/stages

# A working folder with copies of the JSON fixtures, masks.h5 and state.h5 (3, 4, 2 and 1 Gaussians per row).
make_scene() {
  cd "$BATS_TEST_TMPDIR" || return 1
  cp "$data"/*.json .
  "$make_fixture" masks inventory.json masks.h5 0.9
  "$make_fixture" state inventory.json state.h5 3 4 2 1
}

material() { "$bin/pm-material" --scene scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json "$@"; }
candidates() { "$bin/pm-candidates" --scene scene.json --inventory inventory.json --plan plan.json --evidence evidence.json --state state.h5 --out candidates "$@"; }

# Runs the command, expects the exit code and exactly one line on stderr that holds every further argument.
fails_with() { # CODE COMMAND... -- TEXT...
  local code=$1 command=() text
  shift
  while [ "$1" != -- ]; do command+=("$1"); shift; done
  shift
  local status=0
  "${command[@]}" >stdout.txt 2>stderr.txt || status=$?
  cat stderr.txt
  [ "$status" -eq "$code" ] || { echo "exit code $status, expected $code"; return 1; }
  [ ! -s stdout.txt ] || { echo "output on stdout"; return 1; }
  [ "$(wc -l <stderr.txt)" -eq 1 ] || { echo "not one line"; return 1; }
  for text in "$@"; do grep -qF -- "$text" stderr.txt || { echo "no \"$text\""; return 1; }; done
  ! ls -A . candidates screen 2>/dev/null | grep -q '\.tmp' || { echo "a temporary file is left"; return 1; }
}
