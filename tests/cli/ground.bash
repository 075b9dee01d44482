# pm-ground with model servers (tests/cli/server.bash) on the toy of tests/cli/toy.bash.
load server
load toy

setup_file() { make_bundle; }
setup() {
  copy_bundle
  cd "$BATS_TEST_TMPDIR" || return 1
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY
  export PM_API_KEY=pmkey-0123456789
}

teardown() { stop_server; }

ground() { "$bin/pm-ground" --scene scene/scene.json --out run --exchanges exchanges --timeout 20 --budget 40 --retries 1 --backoff 0.05 "$@"; }
# The provider's fault: exit code 4, one line with the texts, no record, the key nowhere.
fails_remotely() { # FLAGS... -- TEXT...
  fails_with 4 ground "$@"
  nothing_is_left
}
nothing_is_left() {
  [ ! -e run ] || [ -z "$(find run -type f)" ] || { echo "a record is left"; return 1; }
  refute grep -rl "$PM_API_KEY" --exclude=requests.log . "$BATS_TEST_TMPDIR/.stderr"
}
