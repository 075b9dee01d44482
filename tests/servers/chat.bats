#!/usr/bin/env bats
# A chat server that other people wrote: llama.cpp's, with a tiny model that tests/servers/tiny_chat.py makes. `make test-servers`.
bats_require_minimum_version 1.5.0
load real
load_from_cli ground

teardown() { end_server; }

@test "real: llama.cpp answers within the schema, about pictures, and its exchanges replay to the same bytes" {
  start_server llamacpp "$BATS_TEST_DIRNAME/tiny_chat.py"
  is_ready /health
  "$bin/pm-ground" check "$server_url" >said
  cat said
  for text in 'models +tiny' 'structured output +json_schema is taken' 'pictures +answers' 'corrections' 'make run'; do grep -qE "ok +$text|$text" said; done
  refute grep -E '^  no' said
  make_remote_scene
  material --agent "$server_url/v1" --model tiny
  # The grammar leaves the model the row's own key, and it abstains.
  grep -q "the agent abstained" evidence.json
  [ "$(find exchanges -name 'material_*.json' | wc -l)" -eq 3 ]
  mv evidence.json live.json
  material --agent replay:exchanges
  cmp evidence.json live.json
  keep llamacpp
  # Fields of its own, and one that it does not know.
  rm -rf exchanges evidence.json
  echo '{"max_tokens": 5}' >body.json
  fails_with 4 material --agent "$server_url/v1" --model tiny --body body.json -- "cut off"
}

@test "real: llama.cpp without a projector says why it does not answer" {
  start_server llamacpp "$BATS_TEST_DIRNAME/tiny_chat.py" --blind
  is_ready /health
  make_remote_scene
  fails_with 4 material --agent "$server_url/v1" --model tiny --retries 0 -- "HTTP" "image input is not supported" mmproj
  status=0
  "$bin/pm-ground" check "$server_url/v1" >said || status=$?
  [ "$status" -eq 4 ]
  cat said
  grep -qE 'ok +text' said
  grep -qE 'no +pictures .*image input is not supported' said
}

@test "real: llama.cpp as scene agent and material agent of a whole run, which replays to the same bytes" {
  start_server llamacpp "$BATS_TEST_DIRNAME/tiny_chat.py"
  is_ready /health
  edit_json scene/scene.json "del d['inventory']"
  # At temperature 0 it gives the first key twice: the schema cannot forbid that, so it is told, says it again, and that is the end.
  fails_with 4 ground --agent "$server_url/v1" --model tiny -- "ground_perception: no acceptable answer in 2 asks" '"r" twice'
  grep -q "Your last answer was rejected" exchanges/ground_perception_2.json
  echo '{"temperature": 1, "top_k": 0, "top_p": 1, "min_p": 0, "seed": 4}' >body.json
  whole() { # RUN AGENT
    env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$bin" THREADS=1 run SCENE=scene/scene.json RUN="$1" \
      SCENE_AGENT="$2" AGENT="$2" BODY=body.json SET="time.frames=4 screening.initial=1 screening.rounds=1 screening.tau=-9 render.width=64 render.height=64" "${@:3}"
  }
  whole run "$server_url/v1" MODEL=tiny
  grep -q '"part": "r"' run/inventory.json
  grep -q "the agent abstained" run/evidence.json
  [ -s run/accepted.json ]
  end_server
  whole again "replay:$PWD/run/exchanges"
  for file in inventory.json plan.json masks.h5 evidence.json; do cmp "run/$file" "again/$file"; done
}
