#!/usr/bin/env bats
# Model servers as they are: what differs between them, one test per difference (tests/tools/server.py imitates it; tests/servers has
# the real ones).
bats_require_minimum_version 1.5.0
load ground
load coarse

material_setup() {
  make_remote_scene
  unset PM_API_KEY
}
# replays_to_the_same FLAGS...: a replay without a server gives the same bytes.
replays_to_the_same() {
  stop_server
  cp evidence.json live.json
  rm evidence.json
  material "$@"
  cmp evidence.json live.json
}
requests() { grep -c '"path": "[^"]*'"$1" requests.log; }

@test "servers: a bare NaN is a missing number of a predictor, and refused by name elsewhere" {
  material_setup
  serve nan
  material --predictor "$url/v2/models/m"
  grep -q 'NaN' exchanges/predictor_cake_plate.json
  python3 - <<'PY'
import json
rows = {r["key"]: r for r in json.load(open("evidence.json"))["rows"]}
crop = rows["cake/sponge"]["observations"]["crops"][0]
assert crop["E_mean"] == -1 and "nu_mean" not in crop and "nu_uncertainty" in crop, crop
PY
  replays_to_the_same --predictor replay:exchanges
  serve nan-boxes
  fails_with 4 ground --perception "$url" -- "/outputs/boxes/data/0: found NaN"
  [ ! -e run/masks.h5 ]
}

@test "servers: a model that says nothing of its tensors" {
  material_setup
  serve no-metadata
  material --predictor "$url/v2/models/m"
  replays_to_the_same --predictor replay:exchanges
}

@test "servers: a server that batches has an axis of 1 in front of every tensor" {
  material_setup
  serve batched
  material --predictor "$url/v2/models/m"
  replays_to_the_same --predictor replay:exchanges
  rm -r exchanges
  serve batched
  ground --perception "$url"
  mv run live
  stop_server
  ground --perception replay:exchanges
  diff -r live run
}

@test "servers: pictures as binary data, where OpenVINO serves and where it is asked for" {
  material_setup
  serve openvino
  material --predictor "$url/v2/models/m"
  grep -q '"binary": true' requests.log
  [ -n "$(find exchanges -name '*.bin')" ]
  grep -q '"tensors": "binary"' exchanges/predictor_cake_plate.json
  replays_to_the_same --predictor replay:exchanges
  rm -r exchanges evidence.json
  serve good
  material --predictor "$url/v2/models/m" --tensors binary
  replays_to_the_same --predictor replay:exchanges
  # The same numbers as in JSON.
  python3 - <<'PY'
import json
def crops(file):
    return [r.get("observations", {}).get("crops") for r in json.load(open(file))["rows"]]
json.dump(crops("live.json"), open("binary.txt", "w"))
PY
  rm -r exchanges evidence.json
  serve good
  material --predictor "$url/v2/models/m" --tensors json
  python3 - <<'PY'
import json
one, two = json.load(open("binary.txt")), [r.get("observations", {}).get("crops") for r in json.load(open("evidence.json"))["rows"]]
for a, b in zip(one, two):
    for x, y in zip(a or [], b or []):
        assert x.keys() == y.keys() and all(abs(x[k] - y[k]) < 1e-6 for k in x if k != "evidence"), (x, y)
PY
  # What is not all there is not used.
  rm -r exchanges evidence.json
  stop_server
  serve binary-length
  fails_with 4 material --predictor "$url/v2/models/m" --tensors binary -- "of JSON, as its header says"
  [ ! -e evidence.json ]
}

@test "servers: detector and segmenter in binary" {
  serve good
  ground --perception "$url" --tensors binary
  mv run live
  stop_server
  ground --perception replay:exchanges
  diff -r live run
  # A changed tensor is noticed.
  for file in exchanges/*.bin; do printf x >>"$file"; done
  fails_with 3 ground --perception replay:exchanges -- ".bin: found other bytes"
}

@test "servers: FP16 goes in binary, which JSON does not have" {
  material_setup
  serve fp16
  material --predictor "$url/v2/models/m"
  grep -q '"E_mean": -1' evidence.json
  replays_to_the_same --predictor replay:exchanges
}

@test "servers: the answer stands where thoughts belong, or in parts" {
  material_setup
  for mode in reasoning parts; do
    rm -rf exchanges evidence.json
    serve $mode
    ask
    grep -q '"Foam": 0.75' evidence.json
    [ "$(requests completions)" -eq 3 ]
    replays_to_the_same --agent replay:exchanges
  done
}

@test "servers: a model that thinks until nothing is left is asked again without, and from then on" {
  material_setup
  serve thinks
  ask
  [ "$(requests completions)" -eq 4 ]
  [ "$(grep -c enable_thinking requests.log)" -eq 3 ]
  refute grep -q "answer of the agent about" evidence.json
  replays_to_the_same --agent replay:exchanges
}

@test "servers: a model without eyes: the reason stands in the error" {
  material_setup
  serve no-projector
  fails_with 4 ask -- "HTTP 500 after 3 attempts: image input is not supported - hint: provide the mmproj"
  stop_server
  serve error-200
  fails_with 4 ask -- "the server answers with an error: the engine is dead"
}

@test "servers: one that is loading its model is waited for, within the budget" {
  material_setup
  for mode in loading loading-silent; do
    rm -rf exchanges evidence.json
    serve $mode
    # One retry at 0.05 s would long be over.
    material --agent "$url" --model tester --retries 1 --backoff 0.2 --budget 20 2>log
    grep -q "HTTP 503: Loading model; waiting for it, 20 s at most" log
    [ "$(grep -c waiting log)" -eq 1 ]
    [ -s evidence.json ]
    stop_server
  done
  # Pictures are not sent again and again: it says itself when it is ready.
  rm -rf exchanges evidence.json
  serve loading
  material --agent "$url" --model tester --retries 0 --backoff 0.1 --budget 20 --quiet
  [ "$(requests completions)" -eq 4 ]
  [ "$(requests models)" -ge 2 ]
  grep -q '"probe": "/v1/models"' exchanges/material_cake_plate_1.json
  stop_server
  rm -rf exchanges evidence.json
  serve loading
  material --predictor "$url/v2/models/m" --retries 0 --backoff 0.1 --budget 20 --quiet
  stop_server
  # Triton answers 400 where a model is not ready, and where there is none: then the server itself is ready.
  rm -rf exchanges evidence.json
  serve loading-triton
  material --predictor "$url/v2/models/m" --retries 0 --backoff 0.1 --budget 20 --quiet
  stop_server
  rm -rf exchanges evidence.json
  serve triton-nobody
  fails_with 4 material --predictor "$url/v2/models/m" -- "HTTP 400: Model version not ready"
  stop_server
  serve loading
  fails_with 4 material --agent "$url" --model tester --budget 0.5 --backoff 0.2 --quiet -- "HTTP 503: Loading model; waiting" "would exceed the budget of 0.5 s"
  [ ! -e evidence.json ]
}

@test "servers: a chat template that wants turns gets the rejected answer between two questions" {
  material_setup
  serve alternate
  ask
  grep -q "Your last answer was rejected" exchanges/material_cake_plate_2.json
  grep -qF '"content": "{\"E\": 1}"' exchanges/material_cake_plate_2.json
  [ "$(requests completions)" -eq 4 ]
  replays_to_the_same --agent replay:exchanges
}

@test "servers: no temperature, another name for max_tokens, no system message: each refusal once" {
  material_setup
  echo '{"max_tokens": 900}' >body.json
  serve strict
  ask --body body.json
  [ "$(requests completions)" -eq 6 ]
  [ "$(grep -c max_completion_tokens requests.log)" -eq 4 ]
  grep -q '"temperature": false' exchanges/material_cake_sponge_1.json
  replays_to_the_same --agent replay:exchanges
  replays_to_the_same --agent replay:exchanges --body body.json
  echo '{"max_tokens": 901}' >body.json
  rm evidence.json
  fails_with 3 material --agent replay:exchanges --body body.json -- /request/body/max_tokens 900 901
}

@test "servers: Qwen's compatible mode wants json_object, the word JSON, and no thinking" {
  material_setup
  serve qwen
  ask
  grep -q '"structure": "json_object"' exchanges/material_cake_sponge_1.json
  grep -q '"thinking": "off"' exchanges/material_cake_sponge_1.json
  [ "$(requests completions)" -eq 5 ]
  replays_to_the_same --agent replay:exchanges
}

@test "servers: one that ignores the schema in silence has read it in the text" {
  material_setup
  serve ignores-schema
  ask
  [ "$(requests completions)" -eq 3 ]
  refute grep -q "answer of the agent about" evidence.json
}

@test "servers: an address with a query, a host of its own, the key under another name" {
  material_setup
  export PM_API_KEY=pmkey-0123456789
  printf '%s\n' '# a gateway' 'Host: models.example' 'api-key: ${PM_API_KEY}' 'X-Tenant: physics-laboratory' >headers.txt
  serve gateway
  material --agent "$url/openai/v1?api-version=2024-10-21" --model tester --headers headers.txt
  grep -qF '/openai/v1/chat/completions?api-version=2024-10-21"' exchanges/material_cake_plate_1.json
  grep -q '"api-key": "\[masked\]"' exchanges/material_cake_plate_1.json
  refute grep -rlE "$PM_API_KEY|physics-laboratory" exchanges evidence.json
  replays_to_the_same --agent replay:exchanges
  rm -r exchanges evidence.json
  serve gateway
  material --predictor "$url/v2/models/m?api-version=2024-10-21" --headers headers.txt
  grep -qF '/v2/models/m/ready?api-version=2024-10-21"' requests.log
  stop_server
  rm -r exchanges evidence.json
  serve gateway
  fails_with 4 material --agent "$url/openai/v1" --model tester --headers headers.txt -- "HTTP 404: Resource not found"
  fails_with 4 material --agent "$url/openai/v1?api-version=2024-10-21" --model tester -- "HTTP 404"
  unset PM_API_KEY
  fails_with 3 material --agent "$url/openai/v1?api-version=2024-10-21" --model tester --headers headers.txt -- "headers.txt: line 3" "not set"
  fails_with 3 material --agent "$url" --model tester --headers nowhere.txt -- nowhere.txt
  [ ! -e evidence.json ]
}

@test "servers: a header's value is in no file, no message and no process's arguments" {
  material_setup
  printf '%s\n' 'X-Api-Key: sEcret-W0rd' 'X-Tenant: physics-laboratory' >headers.txt
  serve refuse-tenant
  fails_with 4 ask --headers headers.txt -- "HTTP 403: no tenant [header], no key [header]"
  stop_server
  # A reply that repeats a credential is not used; of another header it is masked, the same in the record and in what is used.
  serve echo-header-key
  fails_with 4 ask --headers headers.txt -- "repeats the key or a header"
  [ ! -e exchanges ]
  stop_server
  serve echo-tenant
  ask --headers headers.txt
  grep -qF '\"you are\": \"[header]\"' exchanges/material_cake_plate_1.json
  refute grep -rliE 'secret-w0rd|physics-laboratory' exchanges evidence.json
  replays_to_the_same --agent replay:exchanges
  fails_with 2 material --agent "http://127.0.0.1:1/sEcret-W0rd/v1" --model m --headers headers.txt -- "holds the value of the header X-Api-Key"
  refute grep -i secret-w0rd "$BATS_TEST_TMPDIR/.stderr"
  serve redirect-port
  fails_with 4 ask --headers headers.txt -- "127.0.0.1:9" refused
}

@test "servers: --body goes with a chat server, and decides nothing of what is asked" {
  material_setup
  echo '{"messages": []}' >body.json
  fails_with 2 material --body body.json -- "--body" "--agent"
  fails_with 3 material --agent http://127.0.0.1:9 --model m --body body.json -- body.json /messages
  fails_with 2 ground --perception http://127.0.0.1:9 --body body.json -- "--body" "--agent"
}

# --- Through make ---------------------------------------------------------------------------------------------------

make_setup() {
  unset PM_API_KEY
  make_coarse_scene
  echo '{"top_k": 1}' >body.json
  printf 'X-Api-Key: sEcret-W0rd\n' >headers.txt
  ask_by_make() { run_make run GAUSSIANS=bundle/gaussians.ply PROMPT="it falls" UP=z RUN=run SPEC=spec.json DEFAULTS= SET=screening.initial=1 AGENT="$url/v1" MODEL=tester "$@"; }
}

@test "servers: make's TIMEOUT, RETRIES, HEADERS and BODY; only another BODY asks again" {
  make_setup
  serve slow
  run ask_by_make TIMEOUT=1 RETRIES=0
  [[ $output = *"no complete reply within 1 s"*"TIMEOUT="* ]]
  ask_by_make TIMEOUT=30 BUDGET=60 RETRIES=0 HEADERS=headers.txt BODY=body.json
  [ -s run/accepted.json ]
  grep -q '"top_k": 1' run/exchanges/material_*_1.json
  grep -q '"added": \[' run/exchanges/material_*_1.json
  refute grep -rqi secret-w0rd run
  # The server gets it; no process is started with it.
  count=$(wc -l <requests.log)
  ask_by_make TIMEOUT=40 HEADERS=headers.txt BODY=body.json >log
  grep -q '^Nothing to do' log
  [ "$(wc -l <requests.log)" -eq "$count" ]
  echo '{"top_k": 2}' >body.json
  ask_by_make BODY=body.json >log
  grep -q '"top_k": 2' run/exchanges/material_*_1.json
  stop_server
}

@test "servers: make passes a query on, and refuses one that may hold a credential before a folder is made" {
  make_setup
  run_make -n run EXAMPLE=cake AGENT='http://h/v1?api-version=2024-10-21' MODEL=m >log
  grep -qF -- '--agent="$PM_ASKED_AGENT"' log
  while read -r want address; do
    case $want in refused | taken) ;; *) continue ;; esac
    got=$(bash "$root/pipelines/url-credentials.sh" "$address")
    [ "${got:-none}" = "$([ "$want" = refused ] && echo credential || echo none)" ] || { echo "$want $address"; return 1; }
  done <"$root/tests/data/addresses.txt"
  for variable in AGENT SCENE_AGENT PERCEPTION PREDICTOR; do
    for address in 'http://h/v1?api-key=hunter2' 'http://h/v1?a=b&%6bey=hunter2' 'http://me:hunter2@h/v1' 'http://h/v1?a=1#hunter2'; do
      run run_make run EXAMPLE=cake "$variable=$address" MODEL=m
      [ "$status" -eq 2 ]
      [ "${#lines[@]}" -eq 1 ]
      [[ $output = *"$variable holds"*PM_API_KEY*HEADERS* && $output != *hunter2* ]]
      # A number sign begins a comment there.
      printf 'cake "%s=%s"\n' "$variable" "${address//#/@}" >list.txt
      run run_make batch SCENES=list.txt
      [ "$status" -eq 2 ]
      [[ $output = *"$variable holds"* && $output != *hunter2* ]]
    done
  done
  [ ! -e runs ]
}

@test "servers: make refuses what says how a server is asked where none is" {
  make_setup
  refuses_make() { # TEXT ARGUMENT...
    run run_make run EXAMPLE=cake "${@:2}"
    [ "$status" -eq 2 ]
    [ "${#lines[@]}" -eq 1 ]
    [[ $output = *"$1"* ]]
  }
  for variable in TIMEOUT=5 RETRIES=1 HEADERS=headers.txt TENSORS=json BUDGET=7; do refuses_make "${variable%%=*} says how a model server is asked" "$variable"; done
  refuses_make "BODY has fields" BODY=body.json PREDICTOR=http://h/v2/models/m
  refuses_make "expected a number of seconds" TIMEOUT=soon AGENT=http://h MODEL=m
  refuses_make "expected a number" RETRIES=1.5 AGENT=http://h MODEL=m
  refuses_make "HEADERS=none.txt is not there" HEADERS=none.txt AGENT=http://h MODEL=m
  [ ! -e runs ]
}
