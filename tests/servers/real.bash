# Real model servers for tests: PM_SERVERS is the folder that tests/servers/install.sh filled.

# load_from_cli NAME: a helper of tests/cli, which loads others that lie beside it.
load_from_cli() {
  local here=$BATS_TEST_DIRNAME
  BATS_TEST_DIRNAME=$here/../cli
  load "$1"
  BATS_TEST_DIRNAME=$here
}

# The first of three free ports in a row.
free_ports() {
  python3 - <<'PY'
import random, socket
while True:
    port = random.randrange(20000, 30000)
    try:
        for p in range(port, port + 3):
            with socket.socket() as s:
                s.bind(("127.0.0.1", p))
        print(port)
        break
    except OSError:
        pass
PY
}

# start_server ENVIRONMENT SCRIPT ARGUMENT...: a script of examples/servers, or one with its whole name; $url is the address above its
# models, its output is in server.log.
start_server() {
  local place=${PM_SERVERS:?the folder of tests/servers/install.sh}/$1 script=$2 port
  shift 2
  port=$(free_ports)
  case $script in */*) set -- "$script" "$port" "$@" ;; *) set -- "$root/examples/servers/$script" "$@" --port "$port" ;; esac
  cd "$BATS_TEST_TMPDIR" || return 1
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY PM_API_KEY
  # In a session of its own: Triton and KServe start processes. Byte code is kept apart from the sources.
  PYTHONPATH=$root/examples/servers:$root/tests/servers PYTHONPYCACHEPREFIX=$PM_SERVERS/byte-code PYTHONDONTWRITEBYTECODE='' setsid "$place/bin/python" "$@" >server.log 2>&1 3>&- &
  server=$!
  server_url=http://127.0.0.1:$port
  url=$server_url/v2/models
}

# keep NAME: the exchanges of the working folder for tests/data/exchanges, where RECORD names such a folder.
keep() {
  if [ -n "${RECORD:-}" ]; then
    rm -rf "${RECORD:?}/$1"
    cp -r exchanges "$RECORD/$1"
  fi
}

end_server() {
  if [ -n "${server:-}" ]; then
    kill -TERM -- "-$server" 2>/dev/null || true
    for _ in $(seq 50); do kill -0 -- "-$server" 2>/dev/null || break; sleep 0.1; done
    kill -KILL -- "-$server" 2>/dev/null || true
    wait "$server" 2>/dev/null || true
  fi
  server=
}

# Waits until the addresses answer: models of an inference server, or what begins with a slash.
is_ready() { # MODEL...
  for _ in $(seq 300); do
    kill -0 "$server" 2>/dev/null || { tail -n 20 server.log; return 1; }
    python3 - "$server_url" "$@" 2>/dev/null <<'PY' && return
import sys, urllib.request
for name in sys.argv[2:]:
    urllib.request.urlopen(sys.argv[1] + (name if name.startswith("/") else "/v2/models/" + name + "/ready"), timeout=5)
PY
    sleep 0.3
  done
  tail -n 20 server.log
  return 1
}
