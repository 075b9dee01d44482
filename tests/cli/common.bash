# Shared by all command-line tests.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bin=$(realpath "${PM_BIN:-$root/build/bin}")

# Runs the command, expects the exit code, nothing on stdout, and exactly one line on stderr that holds every further
# argument; no temporary file may be left below the working folder.
fails_with() { # CODE COMMAND... -- TEXT...
  local code=$1 command=() text
  shift
  while [ "$1" != -- ]; do command+=("$1"); shift; done
  shift
  local status=0
  "${command[@]}" >"$BATS_TEST_TMPDIR/.stdout" 2>"$BATS_TEST_TMPDIR/.stderr" || status=$?
  cat "$BATS_TEST_TMPDIR/.stderr"
  [ "$status" -eq "$code" ] || { echo "exit code $status, expected $code"; return 1; }
  [ ! -s "$BATS_TEST_TMPDIR/.stdout" ] || { echo "output on stdout"; return 1; }
  [ "$(wc -l <"$BATS_TEST_TMPDIR/.stderr")" -eq 1 ] || { echo "not one line"; return 1; }
  for text in "$@"; do grep -qF -- "$text" "$BATS_TEST_TMPDIR/.stderr" || { echo "no \"$text\""; return 1; }; done
  [ -z "$(find . -name '.*.tmp*')" ] || { echo "a temporary file is left"; return 1; }
}

# The command says no: exit code 1, as grep, cmp and diff have it where nothing is found or something differs. Not `!`, whose
# failure bats ignores, and which is content with a command that could not even read its file.
refute() { # COMMAND...
  local status=0
  "$@" || status=$?
  [ "$status" -eq 1 ] || { echo "exit code $status, expected 1: $*"; return 1; }
}

# --help: exit code 0, the usage on stdout, nothing on stderr.
shows_help() { # TOOL
  "$bin/$1" --help >"$BATS_TEST_TMPDIR/.stdout" 2>"$BATS_TEST_TMPDIR/.stderr"
  grep -q 'Usage:' "$BATS_TEST_TMPDIR/.stdout"
  [ ! -s "$BATS_TEST_TMPDIR/.stderr" ]
  "$bin/$1" --version | grep -q "^$1 [0-9]"
}

# Checksums and modification times of all files below the arguments: equal before and after means untouched.
fingerprint() {
  find "$@" -type f -not -path '*/.stamps/*' -printf '%p %T@ ' -exec sha256sum {} \; | sort
}
