#!/usr/bin/env bats
# Inference servers that other people wrote (tests/servers/install.sh), with the scripts of examples/servers in front and stand-ins
# behind: `make test-servers`.
bats_require_minimum_version 1.5.0
load real
load_from_cli ground

teardown() { end_server; }

# The predictor of a running server; its numbers are as they should be, and its exchanges replay to the same bytes.
has_predictor() { # MODEL FLAGS...
  local model=$1
  shift
  make_remote_scene
  rm -rf exchanges evidence.json
  material --predictor "$url/$model" "$@"
  python3 - <<'PY'
import json
rows = {r["key"]: r for r in json.load(open("evidence.json"))["rows"]}
crops = rows["cake/sponge"]["observations"]["crops"]
assert [c["E_mean"] for c in crops] == [-2, -2] and abs(crops[0]["nu_uncertainty"] - 0.03) < 1e-4, crops
assert "nu_mean" not in crops[0] and crops[0]["evidence"]["Foam"] == 0.5, crops
PY
  mv evidence.json live.json
  material --predictor replay:exchanges
  cmp evidence.json live.json
  rm evidence.json
}

# Masks of a detector and a segmenter, and the labels that they make; a text that nothing stands for.
has_perception() { # FLAGS...
  rm -rf scene run live exchanges
  copy_bundle
  ground --perception "$url" "$@"
  mv run live
  ground --perception replay:exchanges
  diff -r live run
  "$bin/pm-lift" --scene scene/scene.json --inventory run/inventory.json --masks run/masks.h5 --out state.h5
  "$bin/pm-eval" labels --scene scene/scene.json --inventory run/inventory.json --state state.h5 --out labels.json >table
  # The ball lies in its box, the box in its own; where both masks miss a part, neighbours decide.
  python3 -c 'import json; a = json.load(open("labels.json"))["row_accuracy"]; assert a > 0.9, a'
  rm -rf live run exchanges
  edit_json scene/inventory.json "d['rows'][0]['name'] = 'wheel'"
  edit_json scene/scene.json "d['prompt'] = 'the toy falls'"
  # Tensors without elements; Triton's binding has none.
  ground --perception "$url" --log-level info "$@" 2>log
  grep -q "masks of toy/ball: no view shows it" log
}

@test "real: Triton" {
  start_server triton serve_triton.py stand_ins:Predictor stand_ins:HalfPredictor stand_ins:Detector stand_ins:Segmenter
  is_ready predictor half grounding-dino sam2
  has_predictor predictor
  # It writes NaN, which is no JSON.
  grep -q NaN exchanges/predictor_cake_plate.json
  keep triton
  has_predictor predictor --tensors binary
  keep triton-binary
  has_predictor half
  keep triton-half
  [ -n "$(find exchanges -name '*.bin')" ]
  # A model that is not there, and one that fails: the server's words.
  fails_with 4 material --predictor "$url/nobody" -- "HTTP 400" "not"
  copy_bundle
  edit_json scene/inventory.json "d['rows'][0]['name'] = 'crash'"
  fails_with 4 ground --perception "$url" -- "out of memory in the detector"
  has_perception
  has_perception --tensors binary
}

@test "real: Triton with batching has an axis in front of every tensor" {
  start_server triton "$BATS_TEST_DIRNAME/serve_batching.py"
  is_ready predictor grounding-dino sam2
  has_predictor predictor
  keep triton-batching
  has_predictor predictor --tensors binary
  has_perception
}

@test "real: tritonserver on the model repository of examples/servers" {
  cp -r "$root/examples/servers/triton-models" .
  sed -i 's/models:GroundingDino/stand_ins:Detector/; s/models:Sam2/stand_ins:Segmenter/' triton-models/*/config.pbtxt
  [ "$(grep -c stand_ins triton-models/*/config.pbtxt | grep -c ':1$')" -eq 2 ]
  start_server triton "$BATS_TEST_DIRNAME/serve_repository.py" "$PWD/triton-models"
  is_ready grounding-dino sam2
  "$bin/pm-ground" check "$server_url" >said
  cat said
  grep -qE 'ok +grounding-dino +answers .*boxes' said
  has_perception
  has_perception --tensors binary
  # Its words, and it goes on.
  copy_bundle
  edit_json scene/inventory.json "d['rows'][0]['name'] = 'crash'"
  fails_with 4 ground --perception "$url" -- "out of memory in the detector"
}

@test "real: KServe's model server says nothing of its tensors" {
  start_server kserve serve_kserve.py stand_ins:Predictor stand_ins:Detector stand_ins:Segmenter
  is_ready predictor grounding-dino sam2
  has_predictor predictor
  grep -qF '\"inputs\":[]' exchanges/predictor_metadata.json
  keep kserve
  fails_with 4 material --predictor "$url/nobody" -- "HTTP 404: Model with name nobody does not exist"
  has_perception
  # It decodes what comes in binary as UTF-8, which pictures are not.
  fails_with 4 ground --perception "$url" --tensors binary -- "HTTP 500" "Failed to encode"
}

@test "real: MLServer" {
  start_server mlserver serve_mlserver.py stand_ins:Predictor stand_ins:Detector stand_ins:Segmenter
  is_ready predictor grounding-dino sam2
  has_predictor predictor
  keep mlserver
  fails_with 4 material --predictor "$url/nobody" -- "HTTP 404: Model nobody not found"
  has_perception
}
