# make install and make uninstall, man pages, shell completion, and what runs outside the tree.
load common

run_make() {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -C "$root" --no-print-directory SAN="${PM_SAN:-0}" BUILD="$(dirname "$bin")" "$@"
}

setup_file() { run_make install DESTDIR="$BATS_FILE_TMPDIR/root" PREFIX=/usr; }

setup() {
  usr=$BATS_FILE_TMPDIR/root/usr
  cd "$BATS_TEST_TMPDIR"
}

tools=(pm-scene pm-ground pm-lift pm-material pm-candidates pm-simulate pm-render pm-screen pm-report pm-eval)

subcommands() { # TOOL
  "$bin/$1" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\+\) .*/\1/p'
}

# The option names that --help begins a line with.
options_of() { # TOOL [COMMAND]
  "$bin/$1" ${2:+"$2"} --help | sed -n 's/^ \{2,4\}\(-[a-z,-]*\).*/\1/p' | tr , '\n'
}

# What completes the last of the words, one line each.
complete_words() { # TOOL WORD...
  . "$usr/share/bash-completion/completions/$1"
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  "_${1//-/_}"
  printf '%s\n' "${COMPREPLY[@]}"
}

@test "install: every tool, its page and its completion, and what belongs to a run" {
  for tool in "${tools[@]}"; do
    "$usr/bin/$tool" --version | grep -q "^$tool [0-9]"
    [ -s "$usr/share/man/man1/$tool.1" ]
    [ -s "$usr/share/bash-completion/completions/$tool" ]
  done
  [ "$(find "$usr/bin" -type f | wc -l)" -eq "$(find "$root/tools" -name '*.cpp' | wc -l)" ]
  for folder in schemas examples; do
    diff -r "$root/$folder" "$usr/share/physmas/$folder"
  done
  [ -x "$usr/share/physmas/pipelines/batch-scenes.sh" ]
  cmp "$root/docs/artifacts.md" "$usr/share/doc/physmas/artifacts.md"
}

@test "uninstall: takes away what was installed, and nothing else" {
  cp -a "$BATS_FILE_TMPDIR/root" .
  echo mine >root/usr/share/physmas/examples/mine.json
  echo mine >root/usr/bin/mine
  run_make uninstall DESTDIR="$PWD/root" PREFIX=/usr
  [ "$(find root -type f -o -type l | sort)" = "$(printf '%s\n' root/usr/bin/mine root/usr/share/physmas/examples/mine.json)" ]
  [ ! -e root/usr/share/doc/physmas ]
  [ ! -e root/usr/share/physmas/schemas ]
}

@test "uninstall: an error where nothing is installed" {
  run run_make uninstall DESTDIR="$PWD/root" PREFIX=/usr
  [ "$status" -ne 0 ]
  [[ "$output" == *"root/usr/share/physmas/manifest is not there"* ]]
}

@test "install: over an older installation, whose files that are gone now go" {
  cp -a "$BATS_FILE_TMPDIR/root" .
  echo old >root/usr/share/physmas/examples/old.json
  echo share/physmas/examples/old.json >>root/usr/share/physmas/manifest
  run_make install DESTDIR="$PWD/root" PREFIX=/usr
  [ ! -e root/usr/share/physmas/examples/old.json ]
  diff -r root "$BATS_FILE_TMPDIR/root"
}

@test "man pages: every option and command of --help, and every exit code" {
  for tool in "${tools[@]}"; do
    # As a reader sees it: fonts and escaped hyphens away.
    sed 's/\\f[BIR]//g; s/\\-/-/g' "$usr/share/man/man1/$tool.1" >page
    for option in $(options_of "$tool"); do
      grep -qE -- "(^|, )$option( |,|\$)" page || { echo "$tool: no $option"; return 1; }
    done
    for command in $(subcommands "$tool"); do
      # The command's own part of the page; its --help stands with the tool's.
      sed -n "/^\.SS $command\$/,/^\.S[SH] /p" page >part
      [ -s part ]
      for option in $(options_of "$tool" "$command" | grep -vxE -- '-h|--help'); do
        grep -qE -- "^$option( |\$)" part || { echo "$tool $command: no $option"; return 1; }
      done
    done
    for code in $(sed -n '/^enum class ExitCode/,/};/s/.*= \([0-9]*\).*/\1/p' "$root/lib/base/error.h"); do
      grep -qx "$code" page || { echo "$tool: no exit code $code"; return 1; }
    done
    for title in NAME SYNOPSIS DESCRIPTION OPTIONS "EXIT STATUS" EXAMPLES "SEE ALSO"; do
      grep -qxE "\.SH \"?$title\"?" page || { echo "$tool: no $title"; return 1; }
    done
  done
}

@test "man pages: without a warning" {
  command -v mandoc groff >/dev/null || skip "neither mandoc nor groff is installed"
  for tool in "${tools[@]}"; do
    if command -v mandoc >/dev/null; then mandoc -Tlint "$usr/share/man/man1/$tool.1"; fi
    if command -v groff >/dev/null; then
      groff -man -ww -z -Tutf8 "$usr/share/man/man1/$tool.1" 2>warnings
      cat warnings
      [ ! -s warnings ]
    fi
  done
}

@test "completion: options and commands of every tool are those of --help" {
  for tool in "${tools[@]}"; do
    [ "$(complete_words "$tool" - | sort)" = "$(options_of "$tool" | sort)" ]
    for command in $(subcommands "$tool"); do
      complete_words "$tool" "" | grep -qx -- "$command"
      [ -z "$(comm -23 <(options_of "$tool" "$command" | sort) <(complete_words "$tool" "$command" - | sort))" ]
    done
  done
}

@test "completion: values where --help lists them, files and folders otherwise" {
  mkdir folder
  touch file.json
  [ "$(complete_words pm-simulate --precision "" | xargs)" = "float double" ]
  [ "$(complete_words pm-simulate --precision d)" = double ]
  [ "$(complete_words pm-simulate --prec)" = --precision ]
  [ "$(complete_words pm-scene import --up = -)" = "$(printf '%s\n' -x -y -z)" ]
  [ "$(complete_words pm-scene import file.json --log-level w)" = warning ]
  [ "$(complete_words pm-ground --perception "" | xargs)" = "builtin masks: replay:" ]
  [ "$(complete_words pm-simulate --scene f | sort | xargs)" = "file.json folder" ]
  [ "$(complete_words pm-material --exchanges f)" = folder ]
  [ -z "$(complete_words pm-simulate --threads "")" ]
}

@test "install: physmas.mk runs with the tools of its prefix, from any folder" {
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle --quiet
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u BIN make --no-print-directory -f "$usr/share/physmas/physmas.mk" run SCENE=bundle/scene.json \
    RUN=run SET="screening.initial=2 time.frames=10" >log
  cat log
  grep -q '^Accepted' log
  [ -s run/final.mp4 ]
  # A trace of what ran: without the tools of the prefix there is nothing to run with.
  mv "$usr/bin" "$usr/bin.away"
  run env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u BIN PATH=/usr/bin:/bin make -f "$usr/share/physmas/physmas.mk" run SCENE=bundle/scene.json
  mv "$usr/bin.away" "$usr/bin"
  [ "$status" -ne 0 ]
  [[ "$output" == *"are not on PATH"* ]]
}
