#!/usr/bin/env bats
# pm-ground with model servers that answer, and model servers that misbehave: --agent, --perception, COCO masks.
bats_require_minimum_version 1.5.0
load ground

@test "ground: a chat model proposes inventory and plan, and plans what to look for" {
  serve good
  edit_json scene/scene.json "del d['inventory']"
  ground --agent "$url" --model tester
  python3 - <<'PY'
import json
requests = [json.loads(line) for line in open("requests.log")]
assert [r["path"] for r in requests] == ["/v1/chat/completions"] * 2, requests
inventory, plan = json.load(open("run/inventory.json")), json.load(open("run/plan.json"))
assert [r["part"] for r in inventory["rows"]] == ["ball", "box", "residual"]
assert [e["name"] for e in inventory["exchanges"]] == ["ground_schema_1", "ground_perception_1"]
action = plan["actions"][0]
# "the ball" is resolved, 100 m/s is bounded, and both are said; left is left in the front view.
assert action["target"] == "toy/ball" and action["magnitude"] == 3 and action["direction"][0] < -0.99, action
assert len(plan["corrections"]) == 2 and plan["proposal"]["actions"][0]["target"] == "the ball"
# What was asked about stands in the schema that the server may hold answers to.
asked = json.load(open("exchanges/ground_perception_1.json"))["request"]["body"]["response_format"]["json_schema"]["schema"]["properties"]["queries"]
assert asked["minItems"] == asked["maxItems"] == 3 and asked["items"]["properties"]["key"] == {"enum": ["toy", "toy/ball", "toy/box"]}, asked
assert asked["items"]["properties"]["visible_views"]["items"] == {"enum": ["front", "right", "back", "left"]}, asked
PY
  stop_server
  mv run live
  ground --agent replay:exchanges
  diff -r live run
  refute grep -rl "$PM_API_KEY" --exclude=requests.log .
}

@test "ground: an authored inventory is kept, and an answer with another row is asked again, then refused" {
  serve good
  ground --agent "$url" --model tester
  grep -q '"structural_role"' run/inventory.json
  python3 - <<'PY'
import json
asked = json.load(open("exchanges/ground_schema_1.json"))["request"]["body"]["response_format"]["json_schema"]["schema"]["properties"]
assert (asked["objects"]["maxItems"], asked["rows"]["minItems"], asked["rows"]["maxItems"]) == (1, 2, 2), asked
assert asked["objects"]["items"]["properties"]["id"] == asked["rows"]["items"]["properties"]["object"] == {"enum": ["toy"]}, asked
assert asked["rows"]["items"]["properties"]["part"] == {"enum": ["ball", "box"]}, asked
PY
  stop_server
  rm -r run exchanges
  serve unknown-row
  fails_remotely --agent "$url" --model tester -- "no acceptable answer in 2 asks" "toy/wheel" "registered inventory"
  [ "$(wc -l <requests.log)" -eq 2 ]
}

@test "ground: what an answer may not hold is refused with the reason" {
  for case in "outside|unknown field 'E'" "twice|toy/ball\" twice" "no-action|/actions/0/type" "nowhere|piano" "bad-direction|somewhere"; do
    serve "${case%|*}"
    fails_remotely --agent "$url" --model tester -- "no acceptable answer in 2 asks" "${case#*|}"
    stop_server
    rm -r exchanges
  done
  serve outside-once
  ground --agent "$url" --model tester
  grep -q '"what": "an answer of the agent about the scene"' run/inventory.json
  grep -q "Your last answer was rejected" exchanges/ground_schema_2.json
}

@test "ground: a detector and a segmenter make masks, and their exchanges replay to the same bytes" {
  serve good
  ground --perception "$url"
  python3 - <<'PY'
import json
paths = [json.loads(line)["path"] for line in open("requests.log")]
assert paths[:4] == [p for m in ("grounding-dino", "sam2") for p in (f"/v2/models/{m}/ready", f"/v2/models/{m}")], paths
# Three texts in four views, each with a box for the segmenter; no second attempt.
assert len(paths) == 4 + 24, paths
assert len(json.load(open("run/inventory.json"))["exchanges"]) == 28
PY
  stop_server
  mv run live
  ground --perception replay:exchanges
  diff -r live run
  "$bin/pm-lift" --scene scene/scene.json --inventory run/inventory.json --masks run/masks.h5 --out run/state.h5
}

@test "ground: a second attempt where the first left a row without a mask, and no third" {
  serve miss
  ground --agent "$url" --model tester --perception "$url/v2/models"
  [ -s exchanges/ground_repair_1.json ]
  grep -q '"tried' exchanges/ground_repair_1.json || grep -q 'globe' exchanges/ground_repair_1.json
  stop_server
  rm -r run exchanges
  edit_json scene/inventory.json "d['rows'][0]['name'] = 'wheel'"
  edit_json scene/scene.json "d['prompt'] = 'the toy falls'"
  serve good
  ground --perception "$url" --log-level info 2>log
  grep -q "masks of toy/ball: no view shows it" log
  # Two texts found (a detection and a mask each), "wheel" and "toy wheel" not, in four views.
  [ "$(wc -l <requests.log)" -eq $((4 + 4 * (2 * 2 + 2))) ]
}

@test "ground: a detector and a segmenter whose answers break the contract" {
  for case in "not-ready|HTTP 503" "no-such-output|phrases" "bad-score|/outputs/scores/data/0" "bad-box|/outputs/boxes/data/0" \
    "mask-shape|/outputs/masks/shape"; do
    serve "${case%|*}"
    fails_remotely --quiet --budget 5 --perception "$url" -- "${case#*|}"
    stop_server
    rm -rf exchanges
  done
  fails_with 2 ground --agent http://127.0.0.1:1 -- "--model is required"
  fails_with 2 ground --agent somebody -- "expected builtin"
  fails_with 2 ground --perception somebody -- "masks:DIR"
  fails_with 3 ground --perception replay:nowhere -- "no such folder"
}

@test "ground: COCO JSON with polygons and runs" {
  mkdir masks
  python3 - <<'PY'
import json
scene = json.load(open("scene/scene.json"))
categories = [{"id": 1, "name": "ball"}, {"id": 2, "name": "toy/box"}]
images, annotations = [], []
for i, view in enumerate(scene["views"]):
    w, h = view["camera"]["width"], view["camera"]["height"]
    images.append({"id": i, "file_name": f"pictures/{view['name']}.png"})
    square = [0.3 * w, 0.1 * h, 0.7 * w, 0.1 * h, 0.7 * w, 0.5 * h, 0.3 * w, 0.5 * h]
    annotations.append({"image_id": i, "category_id": 1, "segmentation": [square], "score": 0.5})
    runs = {"size": [h, w], "counts": [h * (w // 4), h * (w // 2), h * w - h * (w // 4) - h * (w // 2)]}
    annotations.append({"image_id": i, "category_id": 2, "segmentation": runs})
json.dump({"images": images, "categories": categories, "annotations": annotations}, open("masks/all.json", "w"))
PY
  ground --perception masks:masks
  [ -s run/masks.h5 ]
  rm -r run
  # A mask of the whole image is taken as it is, and reported.
  edit_json masks/all.json "d['annotations'][1]['segmentation']['counts'] = [0, sum(d['annotations'][1]['segmentation']['counts'])]"
  ground --perception masks:masks --log-level info 2>log
  grep -q "the mask of toy/box in front: it covers the whole image" log
  rm -r run
  edit_json masks/all.json "d['annotations'][1]['segmentation']['counts'][0] += 1"
  fails_with 3 ground --perception masks:masks -- all.json /annotations/1/segmentation/counts
  edit_json masks/all.json "d['annotations'].pop(1); d['categories'][0]['name'] = 'wheel'"
  fails_with 3 ground --perception masks:masks -- all.json wheel toy/ball
  [ ! -e run ]
}
