#!/usr/bin/env bats
# Anyone's results: tracks, videos, CLIP, a blinded study, the tables.
bats_require_minimum_version 1.5.0
load tiny
load server

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }
teardown() { stop_server; }

# Two methods on one case; of the second case the rival failed.
make_manifest() {
  "$bin/pm-render" --scene bundle/scene.json --state state.h5 --rollout rollouts/support-stiff.h5 --out run.mp4
  echo '{"text": [1, 0], "frames": [[3, 4]]}' >embeddings.json
  "$bin/pm-eval" clip --embeddings embeddings.json --out clip.json
  cat >evaluation.json <<'JSON'
{"schema": "physmas/evaluation/1",
 "methods": [{"id": "secretive", "name": "Ours"}, {"id": "rivalling", "name": "Rival"}],
 "comparison": ["rivalling", "secretive"], "required": ["clip_sim"],
 "cases": [
  {"id": "one", "kind": "multi-part", "prompt": "it </script> falls", "profiles": ["Jelly"], "results": {
    "secretive": {"status": "done", "video": "run.mp4", "metrics": ["clip.json"]},
    "rivalling": {"status": "done", "video": "run.mp4", "metrics": ["clip.json"]}}},
  {"id": "two", "kind": "multi-part", "prompt": "it rolls", "profiles": ["Metal"], "results": {
    "secretive": {"status": "done", "video": "run.mp4", "metrics": ["clip.json"]},
    "rivalling": {"status": "failed", "reason": "out of memory"}}}]}
JSON
}

@test "pm-eval tracks: a shifted copy has the shift as its error" {
  python3 - <<'PY'
import json
points = [[x * 10.0, y * 10.0] for x in range(5) for y in range(5)]
json.dump({"tracks": [[points, points]], "visibility": [[[1] * 25] * 2]}, open("a.json", "w"))
moved = [[x + 4, y] for x, y in points]
json.dump({"tracks": [[points, moved]], "visibility": [[[1] * 25] * 2]}, open("b.json", "w"))
PY
  "$bin/pm-eval" tracks --reference a.json --tracks b.json --width 100 --height 50 --out metrics.json
  python3 - <<'PY'
import json
m = json.load(open("metrics.json"))["metrics"]
assert abs(m["trajectory_nrmse"]["value"] - 100 * (0.5 * 0.04**2) ** 0.5) < 1e-9, m
assert m["area_log_rmse"] == {"status": "invalid", "reason": "no target masks"}, m
assert m["strain_rmse"]["value"] < 1e-6, m
PY
  head -c 100 /dev/urandom >c.npz
  fails_with 3 "$bin/pm-eval" tracks --reference a.json --tracks c.npz --width 100 --height 50 --out metrics.json -- "c.npz"
}

# Sheared, partly hidden, with a missing point, and gone in the last frame: every number is known.
@test "pm-eval tracks: shear, occlusion, a missing point and an empty mask in closed form" {
  python3 - <<'PY'
import json, math, os, struct, zlib
W, H, k = 200, 100, 0.25
def png(path, inside):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    rows = b"".join(b"\0" + bytes(255 if inside(x, y) else 0 for x in range(W)) for y in range(H))
    chunk = lambda name, data: struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    open(path, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", W, H, 8, 0, 0, 0, 0)) +
                           chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
points = [[20 + 10 * x, 10 + 10 * y] for y in range(7) for x in range(7)]
sheared = [[x + k * y, y] for x, y in points]
whole, half, nothing = lambda x, y: x < 120, lambda x, y: x < 120 and y < 55, lambda x, y: False
for t, (reference, measured) in enumerate(((whole, whole), (whole, half), (whole, nothing))):
    png(f"reference/{t}.png", reference)
    png(f"measured/{t}.png", measured)
missing = [p if i != 8 else [None, None] for i, p in enumerate(sheared)]
ones = [1] * 49
json.dump({"tracks": [points] * 3, "visibility": [ones] * 3}, open("reference.json", "w"))
json.dump({"tracks": [points, missing, sheared], "visibility": [ones] * 3}, open("measured.json", "w"))
# Frame 1 shows the five rows above y = 55, less the missing point; frame 2 shows nothing.
seen = [p for i, p in enumerate(points) if p[1] < 55 and i != 8]
traj = math.sqrt(sum((k * y / W) ** 2 for x, y in seen) / (49 + len(seen)))
# F = [[1, k], [0, 1]]: E = [[0, k / 2], [k / 2, k^2 / 2]]; a point counts with four of its eight neighbours, and all of these have them.
strain = math.sqrt(len(seen) * (2 * (k / 2) ** 2 + (k * k / 2) ** 2) / (49 + len(seen)))
A = 120 * H
area = math.sqrt((math.log(120 * 55 + 1) - math.log(A + 1)) ** 2 / 3 + math.log(A + 1) ** 2 / 3)
json.dump({"trajectory_nrmse": [100 * traj, 49 + len(seen)], "area_log_rmse": [100 * area, 3],
           "strain_rmse": [100 * strain, 49 + len(seen)]}, open("expected.json", "w"))
PY
  "$bin/pm-eval" tracks --reference reference.json --tracks measured.json --width 200 --height 100 --reference-masks reference --masks measured \
    --out metrics.json
  python3 - <<'PY'
import json
found = json.load(open("metrics.json"))["metrics"]
for name, (value, samples) in json.load(open("expected.json")).items():
    # The ridge changes F by about 1e-6.
    assert found[name]["samples"] == samples and abs(found[name]["value"] - value) < 1e-4, (name, found[name], value, samples)
PY
  # A target that frame 0 does not show was not found: nothing is measured, and nothing is zero.
  cp measured/2.png measured/0.png
  "$bin/pm-eval" tracks --reference reference.json --tracks measured.json --width 200 --height 100 --reference-masks reference --masks measured \
    --out metrics.json
  [ "$(grep -c '"status": "invalid"' metrics.json)" -eq 3 ]
  refute grep '"value"' metrics.json
}

@test "pm-eval flow: a video against itself, inside rendered silhouettes" {
  make_manifest
  "$bin/pm-eval" silhouettes --scene bundle/scene.json --inventory inventory.json --state state.h5 --rollout rollouts/support-stiff.h5 --out masks
  "$bin/pm-eval" flow --reference run.mp4 --video run.mp4 --reference-masks masks --masks masks --out metrics.json
  grep -A2 '"area_log_rmse"' metrics.json | grep -q '"value": 0.0'
  refute grep '"value": [1-9]' metrics.json
  rm masks/00000.png
  fails_with 3 "$bin/pm-eval" flow --reference run.mp4 --video run.mp4 --reference-masks masks --out metrics.json -- "masks"
}

@test "pm-eval tracker: a tracker behind the Open Inference Protocol, its replay, and a reply that does not fit" {
  make_manifest
  "$bin/pm-eval" silhouettes --scene bundle/scene.json --inventory inventory.json --state state.h5 --rollout rollouts/support-stiff.h5 --out masks
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY
  tracker() { "$bin/pm-eval" tracker --reference run.mp4 --video run.mp4 --reference-masks masks --tracker "$@" --out metrics.json; }
  serve good
  tracker "$url/v2/models/tracker" --exchanges exchanges --timeout 10
  stop_server
  grep -q '"tracks": "tracker"' metrics.json
  grep -A2 '"trajectory_nrmse"' metrics.json | grep -q '"value": 0.0'
  cp metrics.json live.json
  tracker replay:exchanges
  cmp metrics.json live.json
  serve negative
  fails_with 4 tracker "$url/v2/models/tracker" --timeout 10 -- "visibility, frame 0, point 0" "found 2"
}

@test "pm-eval clip: encoders behind the Open Inference Protocol, and their replay" {
  make_manifest
  printf '#version: 0.2\nf a\n' >merges.txt
  unset http_proxy HTTP_PROXY all_proxy ALL_PROXY
  serve good
  remote() {
    "$bin/pm-eval" clip --video run.mp4 --prompt "it falls" --merges merges.txt --image-encoder "$1" --text-encoder "$2" --out remote.json "${@:3}"
  }
  remote "$url/v2/models/clip-image" "$url/v2/models/clip-text" --exchanges exchanges --timeout 10
  stop_server
  # The mean of ten cosines of 0.6, to rounding.
  python3 -c 'import json; assert abs(json.load(open("remote.json"))["metrics"]["clip_sim"]["value"] - 0.6) < 1e-12'
  cp remote.json live.json
  remote replay:exchanges replay:exchanges
  cmp remote.json live.json
  grep -q '"name": "clip_image_frame_00009"' remote.json
  fails_with 2 "$bin/pm-eval" clip --video run.mp4 --out x.json -- "--embeddings"
}

@test "pm-eval study: the page tells no method, and answers become rates" {
  make_manifest
  "$bin/pm-eval" study --manifest evaluation.json --seed s --out study
  [ "$(ls study/page/videos | wc -l)" -eq 3 ]
  refute grep -iE 'secretive|rivalling|ours' study/page/index.html
  refute grep -E 'secretive|rivalling' <(ls study/page/videos)
  # The prompt cannot end the script element.
  [ "$(grep -c '</script>' study/page/index.html)" -eq 3 ]
  cp study/page/index.html first.html
  "$bin/pm-eval" study --manifest evaluation.json --seed s --out again
  cmp first.html again/page/index.html
  # Three respondents, as the page writes their answers; study-page.bats does the same in a browser.
  python3 - <<'PY'
import json
key = json.load(open("study/key.json"))
for i, name in enumerate(["Ada", "Ben", "Eve"]):
    answers = [{"case": c["id"], "order": list(c["codes"]), "choice": list(c["codes"])[i % 2]} for c in key["cases"]]
    json.dump({"schema": "physmas/answers/1", "token": key["token"], "respondent": name, "answers": answers},
              open(f"answers-{name}.json", "w"))
PY
  "$bin/pm-eval" upr --key study/key.json --answers answers-*.json --out upr.json
  "$bin/pm-eval" upr --key study/key.json --answers answers-*.json --out upr2.json
  cmp upr.json upr2.json
  python3 - <<'PY'
import json
upr = json.load(open("upr.json"))
assert upr["respondents"] == 3 and all(c["responses"] == 3 for c in upr["cases"]), upr
assert {s["name"] for s in upr["sets"]} == {"Jelly", "Metal"}, upr
PY
  fails_with 3 "$bin/pm-eval" upr --key study/key.json --answers answers-Ada.json answers-Ada.json --out x.json -- "/respondent"
}

@test "pm-eval aggregate: tables are not finished over a failure, which is a row" {
  make_manifest
  fails_with 3 "$bin/pm-eval" aggregate --manifest evaluation.json --out tables -- "two, rivalling" "out of memory" "cases.md"
  [ ! -e tables/table1.md ]
  grep -q '^two,Metal,rivalling,failed,.*out of memory' tables/cases.csv
  "$bin/pm-eval" aggregate --manifest evaluation.json --draft --out tables 2>warnings
  grep -q 'two, rivalling' warnings
  grep -q '^| Rival | [*][*]0.6000[*][*] | – | invalid |' tables/table1.md
  grep -q 'multicolumn{2}{c}{Jelly}' tables/table1.tex
  for i in 1 2 3 4; do for e in md tex csv; do [ -s "tables/table$i.$e" ]; done; done
}
