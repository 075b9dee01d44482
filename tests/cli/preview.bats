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

@test "preview: a part marked in Chromium is one of the next run's parts" {
  python3 "$root/tests/tools/browser.py" || skip "no Chromium: apt-get install chromium"
  SCREENSHOTS=${SCREENSHOTS:-} python3 "$root/tests/tools/preview_page.py" run/preview.html marked
  run_make preview GAUSSIANS=bundle/gaussians.ply PROMPT='it falls' UP=z SPEC=spec.json INVENTORY=marked/marked-inventory.json RUN=parts >out 2>&1
  python3 - <<'P'
import json
rows = json.load(open("parts/inventory.json"))["rows"]
assert [r["part"] for r in rows if r["name"] == "the <b>head</b>"] == ["the-b-head-b"], rows
labels = {r["key"]: (r["gaussians"], r["label"]) for r in json.load(open("parts/evidence.json"))["rows"]}
print(labels)
marked = next(v for k, v in labels.items() if k.endswith("/the-b-head-b"))
assert marked[0] > 20 and marked[1] == "Rubber", labels
P
}

@test "preview: pm-report serve writes what is marked into the run, for the page that it gave and nobody else" {
  fails_with 3 "$bin/pm-report" serve --run nowhere -- preview.html
  rm -f run/marked-inventory.json
  "$bin/pm-report" serve --run run --requests 5 >address &
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
P
  wait $server
  grep -q physmas/inventory/1 run/marked-inventory.json
}

@test "preview: the served page in Chromium saves into the run's folder" {
  python3 "$root/tests/tools/browser.py" || skip "no Chromium: apt-get install chromium"
  rm -f run/marked-inventory.json
  "$bin/pm-report" serve --run run --requests 2 >served &
  server=$!
  for _ in $(seq 100); do [ -s served ] && break; sleep 0.1; done
  python3 "$root/tests/tools/preview_page.py" "$(cat served)"
  wait $server
  [ -s run/marked-inventory.json ]
}
