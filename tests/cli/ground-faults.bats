#!/usr/bin/env bats
# pm-ground with model servers that misbehave (tests/tools/server.py): exit code 4, one line, no record, no key.
bats_require_minimum_version 1.5.0
load ground

# The same faults of the chat model, the detector and the segmenter: "agent", "grounding-dino", "sam2".
ask() { # WHO FLAGS...
  local who=$1
  shift
  if [ "$who" = agent ]; then ground --agent "$url" --model tester "$@"; else ground --perception "$url" "$@"; fi
}
# serve_fault WHO FAULT: everyone else behaves.
serve_fault() {
  stop_server
  rm -rf run exchanges
  case $1 in agent) serve "chat:$2" ;; *) serve "$1:$2" ;; esac
}
ask_fails() { # WHO FLAGS... -- TEXT...
  fails_with 4 ask "$@"
  nothing_is_left
}

@test "ground: a refused connection" {
  url=http://127.0.0.1:9
  ask_fails agent -- "127.0.0.1:9" connect "after 2 attempts"
  ask_fails sam2 -- "127.0.0.1:9" connect "after 2 attempts"
}

@test "ground: no reply in time, and one that drips, are not asked again" {
  for case in "agent timeout" "agent drip" "grounding-dino drip" "sam2 timeout"; do
    read -r who fault <<<"$case"
    serve_fault $who $fault
    ask_fails $who --timeout 1 -- "no complete reply within 1 s"
    case $who in agent) path=/chat/ ;; *) path=$who/infer ;; esac
    [ "$(grep -c $path requests.log)" -eq 1 ]
  done
}

@test "ground: 429 waits as long as Retry-After says, and 500 and a reset are tried again" {
  for who in agent grounding-dino; do
    serve_fault $who 429
    start=$(date +%s%N)
    ask $who
    [ $(($(date +%s%N) - start)) -ge 1000000000 ]
    grep -q '"status": 429' exchanges/*.json
    for fault in 500-twice reset-once; do
      serve_fault $who $fault
      ask $who --retries 2
      [ -s run/plan.json ]
    done
  done
}

@test "ground: a wait beyond the budget, and an error that stays" {
  for who in agent grounding-dino; do
    serve_fault $who 429-long
    ask_fails $who -- "HTTP 429" "3600 s would exceed the budget of 40 s"
  done
  for who in agent sam2; do
    serve_fault $who 500
    ask_fails $who -- "HTTP 500 after 2 attempts"
  done
}

@test "ground: a body that is cut off, or is none that this project reads" {
  for case in "agent|cut|after 2 attempts" "agent|wrong-type|text/plain" "agent|html|text/html" \
    "agent|html-as-json|malformed JSON" "grounding-dino|cut|after 2 attempts" "grounding-dino|html|text/html" \
    "sam2|wrong-type|text/plain" "sam2|html-as-json|malformed JSON"; do
    IFS='|' read -r who fault text <<<"$case"
    serve_fault $who $fault
    ask_fails $who -- "$text"
  done
}

@test "ground: JSON outside the schema" {
  for case in "agent|/choices/0/message/content" "grounding-dino|/outputs" "sam2|/outputs"; do
    serve_fault "${case%|*}" no-choices
    ask_fails "${case%|*}" -- "${case#*|}"
  done
  serve_fault agent outside
  ask_fails agent -- "no acceptable answer in 2 asks" "unknown field 'E'"
}

@test "ground: a reply of 100 MB is refused before it is read" {
  for case in "agent|4194304" "sam2|67108864"; do
    serve_fault "${case%|*}" huge
    ask_fails "${case%|*}" -- "expected at most ${case#*|} bytes"
    stop_server
    # Socket buffers take a few megabytes more than the client reads.
    [ "$(sed -n 's/.*"megabytes": \([0-9]*\).*/\1/p' requests.log)" -lt 50 ]
  done
  serve_fault agent huge-chunked
  ask_fails agent -- "expected at most 4194304 bytes"
}

@test "ground: redirects to another host or port are refused" {
  for who in agent grounding-dino; do
    serve_fault $who redirect
    ask_fails $who -- "HTTP 307" "example.invalid" "refused"
  done
  for who in agent sam2; do
    serve_fault $who redirect-port
    ask_fails $who -- "127.0.0.1:9" "refused"
  done
  serve_fault agent redirect-same
  ask agent
  [ -s run/plan.json ]
}

@test "ground: the key appears in no output, whatever the server does with it" {
  for who in agent sam2; do
    serve_fault $who unauthorised
    ask_fails $who -- "HTTP 401" "PM_API_KEY" "[key]"
    serve_fault $who echo
    ask_fails $who -- "repeats the key"
  done
}
