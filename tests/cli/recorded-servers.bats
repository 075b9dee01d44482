#!/usr/bin/env bats
# Exchanges that real servers answered (make test-servers RECORD=tests/data/exchanges writes them), and those that an earlier version
# recorded: they replay to what they said then, without a server.
bats_require_minimum_version 1.5.0
load server

setup() { make_remote_scene; }
recorded() { echo "$root/tests/data/exchanges/$1"; }

# The evidence rests on these very records, byte for byte.
rests_on() { # NAME
  python3 - "$(recorded "$1")" <<'PY'
import hashlib, json, os, sys
folder = sys.argv[1]
used = {e["name"]: e["sha256"] for e in json.load(open("evidence.json"))["exchanges"]}
found = {f[:-5] for f in os.listdir(folder) if f.endswith(".json")}
assert used.keys() == found, (used.keys(), found)
for name, sha256 in used.items():
    record = json.load(open(os.path.join(folder, name + ".json")))
    assert record["sha256"] == sha256, name
    assert hashlib.sha256(record["response"]["body"].encode()).hexdigest() == record["response"]["sha256"], name
PY
}

@test "recorded: predictors of Triton, KServe and MLServer, in JSON, in binary, with batching, in FP16" {
  for name in triton triton-binary triton-half triton-batching kserve mlserver; do
    material --predictor "replay:$(recorded $name)"
    rests_on $name
    python3 - <<'PY'
import json
rows = {r["key"]: r for r in json.load(open("evidence.json"))["rows"]}
crops = rows["cake/sponge"]["observations"]["crops"]
assert [c["E_mean"] for c in crops] == [-2, -2] and abs(crops[0]["nu_uncertainty"] - 0.03) < 1e-4, crops
assert "nu_mean" not in crops[0] and crops[0]["evidence"]["Foam"] == 0.5, crops
PY
  done
}

@test "recorded: llama.cpp" {
  material --agent "replay:$(recorded llamacpp)"
  rests_on llamacpp
  [ "$(grep -c "the agent abstained" evidence.json)" -eq 3 ]
}

@test "recorded: exchanges of version 0.1 replay as they were asked then" {
  material --agent "replay:$(recorded earlier-correction)"
  rests_on earlier-correction
  grep -q "an answer of the agent about cake/plate" evidence.json
  grep -q '"Foam": 0.75' evidence.json
  material --agent "replay:$(recorded earlier-text)"
  rests_on earlier-text
  grep -q '"Foam": 0.75' evidence.json
  material --predictor "replay:$(recorded earlier-predictor)"
  rests_on earlier-predictor
  grep -q '"E_mean": -1' evidence.json
}
