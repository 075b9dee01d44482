#!/usr/bin/env bats
# Model servers that answer, and model servers that misbehave: pm-material --agent and --predictor.
bats_require_minimum_version 1.5.0
load server

setup() {
  make_remote_scene
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY
  export PM_API_KEY=pmkey-0123456789
}

teardown() { stop_server; }

# The provider's fault: exit code 4, one line with the texts, no evidence, the key nowhere.
fails_remotely() { # TEXT...
  fails_with 4 ask -- "$@"
  [ ! -e evidence.json ]
  refute grep -rl "$PM_API_KEY" --exclude=requests.log . "$BATS_TEST_TMPDIR/.stderr"
}

@test "remote: a chat model is asked once per semantic row, and its answers enter the posterior" {
  serve good
  ask
  python3 - <<'PY'
import json
requests = [json.loads(line) for line in open("requests.log")]
assert [r["path"] for r in requests] == ["/v1/chat/completions"] * 3, requests
for r in requests:
    assert r["authorization"] == "Bearer pmkey-0123456789" and r["model"] == "tester" and r["temperature"] == 0
    assert r["image"] == "data:image/png;base64," and r["structured"] == "json_schema" and r["messages"] == 2
rows = {r["key"]: r for r in json.load(open("evidence.json"))["rows"]}
vlm = rows["cake/sponge"]["observations"]["vlm"][0]
# The model names a view that does not exist and leaves one out: the masks are in front and right only.
assert vlm["views"] == ["front", "right"] and vlm["probabilities"] == {"Foam": 0.75, "Plasticine": 0.25}
assert abs(rows["cake/sponge"]["sources"]["vlm"]["Foam"] - 0.30 * 0.8 * 0.75) < 1e-12
assert rows["cake/plate"]["observations"]["vlm"][0]["abstain"] and "vlm" not in rows["cake/plate"]["sources"]
assert "observations" not in rows["cake/residual"]
PY
  grep -q "the agent abstained" evidence.json
  refute grep -rl "$PM_API_KEY" --exclude=requests.log .
}

@test "remote: recorded exchanges replay to the same bytes, without a server" {
  serve good
  ask
  stop_server
  cp evidence.json live.json
  rm evidence.json
  material --agent replay:exchanges
  cmp evidence.json live.json
  # The picture that was sent lies beside the record under its hash.
  picture=$(sed -n 's/.*"\([0-9a-f]*\.png\)".*/\1/p' exchanges/material_cake_sponge_1.json)
  [ "$(sha256sum <"exchanges/$picture" | cut -d' ' -f1).png" = "$picture" ]
}

@test "remote: a replay that does not fit says which field differs" {
  serve good
  ask
  stop_server
  rm evidence.json
  fails_with 3 material --agent replay:exchanges --model other -- material_cake_plate_1.json /request/body/model tester other
  sed -i 's/"name": "Sponge cake"/"name": "Sponge pie"/' inventory.json
  "$make_fixture" masks inventory.json masks.h5 0.9
  "$make_fixture" state inventory.json state.h5 3 4 2 1
  fails_with 3 material --agent replay:exchanges -- material_cake_sponge_1.json /request/body/messages/1/content/0/text "Sponge pie" "Sponge cake"
  cp "$data/inventory.json" .
  rm exchanges/material_cake_icing_1.json
  "$make_fixture" masks inventory.json masks.h5 0.9
  "$make_fixture" state inventory.json state.h5 3 4 2 1
  fails_with 3 material --agent replay:exchanges -- material_cake_icing_1.json "no such record"
  sed -i 's/0\.75/0.85/' exchanges/material_cake_sponge_1.json
  fails_with 3 material --agent replay:exchanges -- material_cake_sponge_1.json /response/sha256 "changed after"
  fails_with 3 material --agent replay:nowhere -- replay:nowhere "no such folder"
  [ ! -e evidence.json ]
}

@test "remote: a refused connection" {
  url=http://127.0.0.1:9
  fails_remotely "127.0.0.1:9" "connect" "after 3 attempts"
}

@test "remote: no reply in time, and one that drips" {
  serve timeout
  fails_remotely "no complete reply within 1 s"
  [ "$(wc -l <requests.log)" -eq 1 ]
  stop_server
  serve drip
  fails_remotely "no complete reply within 1 s"
}

@test "remote: 429 waits as long as Retry-After says, and 408, 500 and a reset are tried again" {
  serve 429
  start=$(date +%s%N)
  ask
  [ $(($(date +%s%N) - start)) -ge 1000000000 ]
  grep -q '"status": 429' exchanges/material_cake_plate_1.json
  for mode in 500-twice 408-once reset-once; do
    stop_server
    rm evidence.json
    serve $mode
    ask
    [ -s evidence.json ]
  done
}

@test "remote: what is asked to wait beyond the budget, and errors that stay" {
  serve 429-long
  fails_remotely "HTTP 429" "3600 s would exceed the budget of 4 s"
  stop_server
  serve 500
  fails_remotely "HTTP 500 after 3 attempts"
  [ "$(wc -l <requests.log)" -eq 3 ]
  stop_server
  # What a server does not do it will not do the next time: each way of asking for structured output once.
  serve 501
  fails_remotely "HTTP 501" "no such thing here"
  [ "$(wc -l <requests.log)" -eq 3 ]
}

@test "remote: a body that is cut off, or none that this project reads" {
  serve cut
  fails_remotely "after 3 attempts"
  for case in "wrong-type|text/plain" "html|text/html" "html-as-json|malformed JSON" "no-choices|/choices/0/message/content" "truncated-answer|cut off"; do
    stop_server
    serve "${case%|*}"
    fails_remotely "${case#*|}"
    [ ! -e exchanges/material_cake_plate_1.json ] || [[ ${case%|*} = no-choices || ${case%|*} = truncated-answer ]]
    rm -rf exchanges
  done
}

@test "remote: an answer outside the schema is asked again once, with the reason recorded" {
  serve outside
  fails_remotely "no acceptable answer in 2 asks" "unknown field 'E'"
  stop_server
  serve other-row
  fails_remotely "cake/candle" "cake/plate"
  stop_server
  rm -r exchanges
  serve outside-once
  ask
  grep -q '"what": "an answer of the agent about cake/plate"' evidence.json
  grep -q "Your last answer was rejected" exchanges/material_cake_plate_2.json
  [ "$(wc -l <requests.log)" -eq 4 ]
}

@test "remote: a server without structured output, and answers wrapped in prose" {
  serve no-schema
  ask
  # A refusal of each kind, then plain JSON for all three rows.
  [ "$(grep -c '"structured": "json_' requests.log)" -eq 2 ]
  [ "$(wc -l <requests.log)" -eq 5 ]
  grep -q '"status": 400' exchanges/material_cake_plate_1.json
  cp evidence.json live.json
  stop_server
  material --agent replay:exchanges
  cmp evidence.json live.json
  serve prose
  ask
  grep -q '"Foam": 0.75' evidence.json
}

@test "remote: a reply of 100 MB is refused before it is read" {
  serve huge
  fails_remotely "expected at most 4194304 bytes"
  stop_server
  serve huge-chunked
  fails_remotely "expected at most 4194304 bytes"
  stop_server
  # Socket buffers take a few megabytes more than the client reads.
  [ "$(sed -n 's/.*"megabytes": \([0-9]*\).*/\1/p' requests.log)" -lt 50 ]
}

@test "remote: redirects to another host or port are refused, on the same one they are followed" {
  serve redirect
  fails_remotely "HTTP 307" "example.invalid" "refused"
  stop_server
  serve redirect-port
  fails_remotely "127.0.0.1:9" "refused"
  stop_server
  serve redirect-get
  fails_remotely "HTTP 302"
  stop_server
  serve redirect-loop
  fails_remotely "one redirect after another"
  stop_server
  serve redirect-same
  ask
  [ -s evidence.json ]
}

@test "remote: the key appears in no output, whatever the server does with it" {
  serve unauthorised
  fails_remotely "HTTP 401" "PM_API_KEY" "[key]"
  # A key that is a part of what stands for it.
  PM_API_KEY=key fails_with 4 ask -- "HTTP 401" "[key]"
  stop_server
  serve echo
  fails_remotely "repeats the key"
  [ ! -e exchanges ]
  PM_API_KEY=$'bad\nkey' fails_with 2 material --agent "$url" --model m -- PM_API_KEY
}

# No four letters of the key, in any case.
refute_key() {
  refute grep -rliE 'sEcr|Ecre|cret|W0rd' --exclude=requests.log .
  refute grep -liE 'sEcr|Ecre|cret|W0rd' "$BATS_TEST_TMPDIR/.stderr"
}

@test "remote: the key is masked in any case and spelling, before a text is cut" {
  export PM_API_KEY=sEcret-W0rd
  serve key-in-type
  ask
  grep -q '\[key\]' exchanges/*.json
  refute grep -rli secret-w0rd exchanges evidence.json
  rm -r exchanges evidence.json
  stop_server
  for mode in key-in-redirect key-in-capitals key-in-escapes key-in-broken-json; do
    serve $mode
    fails_with 4 ask -- key
    refute_key
    [ ! -e evidence.json ]
    [ ! -e exchanges ]
    stop_server
  done
  fails_with 2 material --agent http://127.0.0.1:1/SECRET-w0rd/v1 --model m -- PM_API_KEY
  refute_key
}

@test "remote: usage errors show no more of the URL than its host" {
  fails_with 2 material --agent http://127.0.0.1:1 -- "--model is required"
  fails_with 2 material --agent http://me:secret@host/v1 --model m -- "user name in the URL of host"
  refute grep secret "$BATS_TEST_TMPDIR/.stderr"
  fails_with 2 material --agent "http://host/v1?key=secret" --model m -- "in the query of the URL of host"
  refute grep secret "$BATS_TEST_TMPDIR/.stderr"
  fails_with 2 material --agent ftp://host/v1 --model m -- "scheme \"ftp\""
  fails_with 2 material --agent somebody -- "--agent somebody" "expected builtin"
  [ ! -e evidence.json ]
}

@test "remote: a predictor behind the Open Inference Protocol gives crops and the whole-object record" {
  serve good
  material --predictor "$url/v2/models/m"
  python3 - <<'PY'
import json
paths = [json.loads(line)["path"] for line in open("requests.log")]
assert paths == ["/v2/models/m/ready", "/v2/models/m"] + ["/v2/models/m/infer"] * 4, paths
evidence = json.load(open("evidence.json"))
rows = {r["key"]: r for r in evidence["rows"]}
crops = rows["cake/sponge"]["observations"]["crops"]
assert len(crops) == 2 and crops[0]["E_mean"] == -1 and "nu_mean" not in crops[0] and crops[0]["evidence"]["Foam"] == 0.6
assert rows["cake/sponge"]["E"]["records"] == 2 and rows["cake/sponge"]["nu"]["records"] == 0
assert evidence["whole_object"]["source"] == "crop" and evidence["whole_object"]["label"] == "Foam"
PY
  cp evidence.json live.json
  stop_server
  material --predictor replay:exchanges
  cmp evidence.json live.json
}

@test "remote: a predictor that is not ready, lacks an output, or answers with another shape" {
  predictor_fails() {
    fails_with 4 material --predictor "$url/v2/models/m" --timeout 1 --retries 1 --backoff 0.05 --quiet --budget 2 -- "$@"
    [ ! -e evidence.json ]
  }
  serve not-ready
  predictor_fails "HTTP 503; waiting" "would exceed the budget of 2 s"
  stop_server
  serve no-such-output
  predictor_fails /outputs label_evidence
  stop_server
  serve shape
  predictor_fails /outputs/label_evidence/shape "[2, 13]" "[2, 14]"
  stop_server
  serve missing-output
  predictor_fails "no output named \"label_evidence\""
  stop_server
  serve negative
  predictor_fails /outputs/E_uncertainty/data/0 "-1"
}
