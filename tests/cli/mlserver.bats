#!/usr/bin/env bats
# The Open Inference Protocol client against MLServer, a server that other people wrote. Runs where PM_MLSERVER names the
# program (pip install mlserver), and is skipped elsewhere.
load server
load toy

setup() {
  [ -n "${PM_MLSERVER:-}" ] || skip "PM_MLSERVER is not set"
  cd "$BATS_TEST_TMPDIR" || return 1
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY
  cp -r "$root"/tests/tools/mlserver models
  # Three free ports.
  read -r http grpc metrics < <(python3 -c 'import socket; s = [socket.socket() for _ in range(3)]; [x.bind(("127.0.0.1", 0)) for x in s]; print(*(x.getsockname()[1] for x in s))')
  echo "{\"host\": \"127.0.0.1\", \"http_port\": $http, \"grpc_port\": $grpc, \"metrics_port\": $metrics, \"parallel_workers\": 0}" >models/settings.json
  PYTHONPATH=$PWD/models "$PM_MLSERVER" start models >mlserver.log 2>&1 3>&- &
  server=$!
  url=http://127.0.0.1:$http/v2/models
  for _ in $(seq 300); do
    python3 -c "import urllib.request; [urllib.request.urlopen('$url/' + m + '/ready') for m in ('predictor', 'grounding-dino', 'sam2')]" 2>/dev/null && break
    sleep 0.2
  done
}

teardown() {
  if [ -n "${server:-}" ]; then kill "$server" && wait "$server" || true; fi
}

@test "mlserver: readiness, metadata and inference of a predictor" {
  make_remote_scene
  material --predictor "$url/predictor"
  python3 - <<'PY'
import json
rows = {r["key"]: r for r in json.load(open("evidence.json"))["rows"]}
crops = rows["cake/sponge"]["observations"]["crops"]
assert [c["E_mean"] for c in crops] == [-2, -2] and abs(crops[0]["nu_uncertainty"] - 0.03) < 1e-6
assert crops[0]["evidence"]["Foam"] == 0.5
PY
  fails_with 4 material --predictor "$url/nobody" -- "HTTP 404"
}

@test "mlserver: a detector and a segmenter make masks, and their exchanges replay to the same bytes" {
  make_bundle
  copy_bundle
  ground() { "$bin/pm-ground" --scene scene/scene.json --out "$1" "${@:2}"; }
  ground live --exchanges exchanges --perception "$url"
  ground again --perception replay:exchanges
  diff -r live again
  "$bin/pm-lift" --scene scene/scene.json --inventory live/inventory.json --masks live/masks.h5 --out state.h5
  "$bin/pm-eval" labels --scene scene/scene.json --inventory live/inventory.json --state state.h5 --out labels.json >table
  # The ball lies in its box, the box in its own; where both masks miss a part, neighbours decide.
  python3 -c 'import json; a = json.load(open("labels.json"))["row_accuracy"]; assert a > 0.9, a'
  # Nothing is found of a wheel: the detector answers with tensors of no elements.
  edit_json scene/inventory.json "d['rows'][0]['name'] = 'wheel'"
  edit_json scene/scene.json "d['prompt'] = 'the toy falls'"
  ground lost --perception "$url" --log-level info 2>log
  grep -q "masks of toy/ball: no view shows it" log
  fails_with 4 ground none --perception "$url" --detector nobody -- "HTTP 404"
}
