#!/usr/bin/env bats
# The Open Inference Protocol client against MLServer, a server that other people wrote. Runs where PM_MLSERVER names the
# program (pip install mlserver), and is skipped elsewhere.
load server

setup() {
  [ -n "${PM_MLSERVER:-}" ] || skip "PM_MLSERVER is not set"
  make_remote_scene
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY
  cp "$root"/tests/tools/mlserver/* .
  # Three free ports.
  read -r http grpc metrics < <(python3 -c 'import socket; s = [socket.socket() for _ in range(3)]; [x.bind(("127.0.0.1", 0)) for x in s]; print(*(x.getsockname()[1] for x in s))')
  echo "{\"host\": \"127.0.0.1\", \"http_port\": $http, \"grpc_port\": $grpc, \"metrics_port\": $metrics, \"parallel_workers\": 0}" >settings.json
  PYTHONPATH=$PWD "$PM_MLSERVER" start . >mlserver.log 2>&1 3>&- &
  server=$!
  url=http://127.0.0.1:$http/v2/models/predictor
  for _ in $(seq 300); do
    python3 -c "import urllib.request; urllib.request.urlopen('$url/ready')" 2>/dev/null && break
    sleep 0.2
  done
}

teardown() {
  if [ -n "${server:-}" ]; then kill "$server" && wait "$server" || true; fi
}

@test "mlserver: readiness, metadata and inference" {
  material --predictor "$url"
  python3 - <<'PY'
import json
rows = {r["key"]: r for r in json.load(open("evidence.json"))["rows"]}
crops = rows["cake/sponge"]["observations"]["crops"]
assert [c["E_mean"] for c in crops] == [-2, -2] and abs(crops[0]["nu_uncertainty"] - 0.03) < 1e-6
assert crops[0]["evidence"]["Foam"] == 0.5
PY
  fails_with 4 material --predictor "${url%/predictor}/nobody" -- "HTTP 404"
}
