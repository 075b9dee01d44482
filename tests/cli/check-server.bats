#!/usr/bin/env bats
# pm-ground check: a conversation with a model server before anything is run.
bats_require_minimum_version 1.5.0
load server

setup() {
  cd "$BATS_TEST_TMPDIR" || return 1
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY PM_API_KEY
}
teardown() { stop_server; }

check() { "$bin/pm-ground" check --timeout 5 --budget 10 "$@"; }
# check_says STATUS ARGUMENT... -- TEXT...: in at most twelve lines on stdout.
check_says() {
  local status=0 expected=$1 command=()
  shift
  while [ "$1" != -- ]; do command+=("$1"); shift; done
  shift
  check "${command[@]}" >said 2>errors || status=$?
  cat said errors
  [ "$status" -eq "$expected" ] || { echo "exit code $status, expected $expected"; return 1; }
  [ "$(wc -l <said)" -le 12 ]
  for text in "$@"; do grep -qE -- "$text" said || { echo "no \"$text\""; return 1; }; done
}

@test "check: a chat server that does all of it" {
  serve good
  check_says 0 "$url/v1" -- '^http://127.0.0.1:[0-9]+/v1$' 'ok +models +tester' 'ok +text +answers in' 'ok +structured output +json_schema is taken' \
    'ok +pictures .*a red one is red' 'ok +corrections' 'make run ... AGENT=http.*/v1 .*MODEL=tester'
  refute grep -E '^  (no|note)' said
  # Nothing is written unless it is asked for.
  [ ! -e exchanges ]
  check_says 0 "$url/v1" --exchanges kept -- 'ok +run'
  [ -s kept/check_text_1.json ]
  check_says 0 "$url/v1" --model another -- 'note +models +another is not among tester'
}

@test "check: what a chat server does not take is said, and a run can still work" {
  serve qwen
  check_says 0 "$url/v1" -- 'note +structured output +json_schema is refused, json_object is taken' 'note +manner +thinking is turned off' 'ok +run'
  stop_server
  serve no-schema
  check_says 0 "$url/v1" -- 'note +structured output +refused'
  stop_server
  serve strict
  check_says 0 "$url/v1" -- 'temperature 0 is refused' 'system messages are refused'
  stop_server
  serve blind
  check_says 0 "$url/v1" -- 'note +pictures .*calls a red one "none"'
}

@test "check: what keeps a run from working" {
  serve no-projector
  check_says 4 "$url/v1" -- 'no +text .*HTTP 500'
  refute grep -E 'make run' said
  stop_server
  serve unauthorised
  check_says 4 "$url/v1" -- 'no +key +HTTP 401: no key, no answer; is PM_API_KEY'
  stop_server
  check_says 4 http://127.0.0.1:9/v1 -- "no +models .*connect"
  fails_with 2 check "http://h/v1?key=hunter2" -- "credential in the query of the URL of h"
  fails_with 2 check ftp://h -- "scheme"
}

@test "check: an inference server, and single models of it" {
  serve good
  check_says 0 "$url" -- 'ok +server +tests 1, with the binary tensor extension' 'ok +grounding-dino +is ready, as a detector' 'grounding-dino +answers in .*boxes \[0, 4\]' \
    'ok +sam2 .*masks \[1, 64, 64\]' 'make run ... PERCEPTION='
  check_says 0 "$url/v2/models/m" -- 'ok +m +is ready, as a predictor' 'label_evidence \[1, 14\]' 'PREDICTOR='
  check_says 0 "$url/v2/models/m" --tensors binary -- 'answers in .*, in binary'
  check_says 0 "$url/v2/models/tracker" -- 'as a tracker' 'tracks \[1, 2, 1, 2\]'
  stop_server
  serve no-metadata
  check_says 0 "$url/v2/models/m" -- 'note +m +says nothing of its tensors' 'ok +m +answers'
  stop_server
  serve mask-shape
  check_says 4 "$url" -- 'no +sam2 .*/outputs/masks/shape'
  stop_server
  serve triton-nobody
  check_says 4 "$url/v2/models/nobody" -- 'no +nobody .*Model version not ready'
}
