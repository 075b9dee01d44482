#!/usr/bin/env bats
# make preview: the page before the waiting, and a part that is marked on it.
bats_require_minimum_version 1.5.0
load common
load coarse

setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  make_coarse_scene
  run_make preview GAUSSIANS=bundle/gaussians.ply PROMPT='it <script>alert(1)</script> falls' UP=z SPEC=spec.json RUN=run >log 2>&1
}
setup() { cd "$BATS_FILE_TMPDIR" || return 1; }

@test "preview: page, picture and record, and none of what takes time" {
  grep -q 'page     run/preview.html' log
  [ -s run/preview.png ]
  grep -q '"decision": "preview"' run/preview.json
  [ ! -e run/rollouts ]
  [ "$(grep -o '<script' run/preview.html | wc -l)" -eq 2 ]
  refute grep -q '<script>alert' run/preview.html
  refute grep -qE '(src|href)="?(http|//)' run/preview.html
  # Axes, floor, box, up and front in each of four views.
  for kind in ax ay az floor box up front; do [ "$(grep -o "class=\"$kind\"" run/preview.html | wc -l)" -ge 4 ]; done
}

@test "preview: the coarse motion of the first candidate that moves, in the page, as a film and in the picture" {
  grep -q '<video controls loop muted' run/preview.html
  grep -q 'The candidate [a-z ]* on 12 cells along each edge in place of 24' run/preview.html
  [ "$(head -c 12 run/preview.mp4 | tail -c 8)" = ftypisom ]
  [ "$(grep -o '"path": "preview.mp4"' run/preview.json | wc -l)" -eq 1 ]
  "$bin/pm-report" preview --run run --out one.html --threads 1
  cmp one.html run/preview.html
  # Nothing that could move: said, and no film of an earlier one.
  cp -r run still
  rm -r still/candidates
  "$bin/pm-report" preview --run still
  [ ! -e still/preview.mp4 ]
  # In the picture: two rows of views, and one of the motion.
  height() { printf '%d' "0x$(od -An -tx1 -j20 -N4 "$1" | tr -d ' ')"; }
  [ "$(($(height run/preview.png) * 3))" -gt "$(($(height still/preview.png) * 4))" ]
  grep -q 'there is no candidate yet' still/preview.html
  grep -q '"what": "coarse motion"' still/preview.json
}

@test "preview: a second call does nothing, another prompt writes the page again, and a run goes on from it" {
  again() { run_make preview GAUSSIANS=bundle/gaussians.ply UP=z SPEC=spec.json RUN=again "$@" 2>/dev/null; }
  again PROMPT='it falls' >/dev/null
  fingerprint again >before
  refute grep -q . <(again PROMPT='it falls' | grep -vE '^  (page|picture) ')
  fingerprint again >after
  cmp before after
  again PROMPT='someone pushes it to the left' >out
  grep -q preview out
  grep -q 'class="act' again/preview.html
  run_make run GAUSSIANS=bundle/gaussians.ply UP=z SPEC=spec.json RUN=again PROMPT='someone pushes it to the left' >out 2>/dev/null
  refute grep -qE '^  (ground|lift|material|candidates) ' out
  grep -q '^Accepted' out
}

@test "preview: what was not grounded is refused, and a variable that it has not" {
  mkdir -p bare
  cp -r run/spec run/bundle bare
  fails_with 3 "$bin/pm-report" preview --run bare -- "no inventory.json"
  [ ! -e bare/preview.html ]
  fails_with 2 "$bin/pm-report" preview -- --run
  run run_make preview SCENE=bundle/scene.json RUN=x SCENES=y
  [ "$status" -eq 2 ]
  [[ "$output" = *"has no variable SCENES"* ]]
}

@test "preview: what was marked, stated and changed in Chromium is in the next run's records" {
  python3 "$root/tests/tools/browser.py" || skip "no Chromium: apt-get install chromium"
  pushed=(GAUSSIANS=bundle/gaussians.ply PROMPT='someone pushes it to the left' UP=z SPEC=spec.json)
  run_make preview "${pushed[@]}" RUN=pushed >out 2>&1
  SCREENSHOTS=${SCREENSHOTS:-} python3 "$root/tests/tools/preview_page.py" pushed/preview.html marked
  pushed+=(INVENTORY=marked/marked-inventory.json AUTHORED=marked/marked-materials.json PLAN=marked/marked-plan.json)
  run_make run "${pushed[@]}" RUN=parts >out 2>&1 || cat out
  python3 - <<'P'
import glob, json
rows = json.load(open("parts/inventory.json"))["rows"]
assert [r["part"] for r in rows if r["name"] == "the <b>head</b>"] == ["the-b-head-b"], rows
evidence = {r["key"]: r for r in json.load(open("parts/evidence.json"))["rows"]}
marked = next(r for k, r in evidence.items() if k.endswith("/the-b-head-b"))
assert marked["gaussians"] > 20 and marked["label"] == "Rubber", marked
key, stated = next((k, r) for k, r in evidence.items() if "stated" in r)
assert stated["stated"] == {"label": "Foam", "E": 45000, "nu": 0.31, "rho": 321} and stated["label"] == "Foam", stated
candidates = [json.load(open(f)) for f in glob.glob("parts/candidates/*.json") if "round" not in f]
assert candidates
for c in candidates:
    row = next(r for r in c["rows"] if r["key"] == key)
    assert (row["label"], row["branch"], row["E"], row["nu"], row["rho"]) == ("Foam", "Foam", 45000, 0.31, 321), row
    move = [o for o in c["schedule"] if "velocity" in o]
    assert [round(v, 9) for v in move[0]["velocity"]] == [0.126, 0, 0.168], move
plan = json.load(open("parts/plan.json"))
assert plan["actions"][0]["magnitude"] == 0.21 and plan["proposal"] == {"agent": "authored"}, plan
names = {i["path"].rsplit("/", 1)[-1] for f in ("plan", "evidence") for i in json.load(open(f"parts/{f}.json"))["provenance"]["inputs"]}
assert {"marked-plan.json", "marked-materials.json"} <= names, names
P
  grep -q 'stated: Foam E 45 kPa ν 0.31 ρ 321' parts/report.html
  grep -q 'PLAN=marked/marked-plan.json' parts/report.html
  # Another strength makes the run again from the plan on.
  sed -i 's/"magnitude": 0.21/"magnitude": 0.1/' marked/marked-plan.json
  run_make run "${pushed[@]}" RUN=parts >out 2>/dev/null || true
  grep -q '^  ground ' out
  grep -q '"magnitude": 0.1' parts/plan.json
}

@test "preview: pm-report serve writes what is marked into the run, for the page that it gave and nobody else" {
  fails_with 3 "$bin/pm-report" serve --run nowhere -- preview.html
  rm -f run/marked-inventory.json
  "$bin/pm-report" serve --run run --requests 8 >address &
  server=$!
  for _ in $(seq 100); do [ -s address ] && break; sleep 0.1; done
  url=$(cat address)
  python3 - "$url" <<'P'
import json, sys, urllib.error, urllib.request
url = sys.argv[1].strip()
origin = url[:url.index("/", 8)]
assert origin.startswith("http://127.0.0.1:")
def ask(address, data=None, headers={}):
    try:
        return urllib.request.urlopen(urllib.request.Request(address, data, headers)).status
    except urllib.error.HTTPError as e:
        return e.code
inventory = json.load(open("run/inventory.json"))
for own in ("provenance", "exchanges", "omitted"):
    inventory.pop(own, None)
body, kind = json.dumps(inventory).encode(), {"Content-Type": "application/json"}
assert ask(origin + "/preview.html") == 404
assert ask(url) == 200
assert ask(url + "inventory", body, {**kind, "Origin": "http://evil.example"}) == 403
assert ask(url + "inventory", b"{}", {**kind, "Origin": origin}) == 400
assert ask(url + "inventory", body, {**kind, "Origin": origin}) == 200
materials = {"schema": "physmas/material_records/1", "rows": [{"key": "a/b", "stated": {"E": 1e5}}]}
assert ask(url + "materials", json.dumps(materials).encode(), {**kind, "Origin": origin}) == 200
materials["rows"][0]["stated"]["nu"] = 0.5
assert ask(url + "materials", json.dumps(materials).encode(), {**kind, "Origin": origin}) == 400
assert ask(url + "anything", body, {**kind, "Origin": origin}) == 404
P
  wait $server
  grep -q physmas/inventory/1 run/marked-inventory.json
  grep -q '"E": 100000.0' run/marked-materials.json
}

@test "preview: the served page in Chromium saves into the run's folder" {
  python3 "$root/tests/tools/browser.py" || skip "no Chromium: apt-get install chromium"
  run_make preview GAUSSIANS=bundle/gaussians.ply PROMPT='someone pushes it to the left' UP=z SPEC=spec.json RUN=pushed >out 2>&1
  rm -f pushed/marked-*.json
  "$bin/pm-report" serve --run pushed --requests 4 >served &
  server=$!
  for _ in $(seq 100); do [ -s served ] && break; sleep 0.1; done
  python3 "$root/tests/tools/preview_page.py" "$(cat served)"
  wait $server
  [ -s pushed/marked-inventory.json ]
  grep -q '"rho": 321' pushed/marked-materials.json
  grep -q '"magnitude": 0.21' pushed/marked-plan.json
}
