# A local model server for tests of remote back ends: tests/tools/server.py.
load stages

make_remote_scene() {
  make_scene
  "$make_fixture" views scene.json
}

# serve MODE: starts the server; $url is its address. It ends with stop_server, at the latest after a minute.
serve() {
  rm -f port requests.log
  mkfifo hold.$$ 2>/dev/null || true
  python3 "$root/tests/tools/server.py" port requests.log "$1" <hold.$$ >server.log 2>&1 3>&- &
  server=$!
  exec 9>hold.$$
  for _ in $(seq 200); do
    [ -s port ] && break
    sleep 0.02
  done
  url=http://127.0.0.1:$(cat port)
}

stop_server() {
  exec 9>&- || true
  if [ -n "${server:-}" ]; then wait "$server" || true; fi
  server=
}

# An agent that gives up quickly, so that tests are short.
ask() { material --agent "$url" --model tester --timeout 1 --budget 4 --retries 2 --backoff 0.05 "$@"; }
