#!/usr/bin/env bats
# The page of a run, and a page of many: what is in them, and how they look in a browser.
bats_require_minimum_version 1.5.0
load common
load coarse

# A name, a prompt and a part that would be markup.
setup_file() {
  cd "$BATS_FILE_TMPDIR" || return 1
  make_coarse_scene
  sed 's|"name": "candy"|"name": "<script>alert(1)</script><b>\&amp;"|' "$root/tests/data/tiny.json" >odd.json
  "$bin/pm-scene" synth odd.json --out bundle --quiet
  run_make run SCENE=bundle/scene.json PROMPT='it falls </title><script>alert(2)</script>' SPEC=spec.json RUN=run >log 2>&1
  run_make run SCENE=bundle/scene.json SPEC=spec.json SET=screening.tau=9 RUN=refused >refused.log 2>&1 || true
  # A run that was interrupted after its parts were found.
  mkdir -p failed
  cp -r run/spec run/inventory.json run/plan.json run/state.h5 run/masks.h5 failed
}

setup() { cd "$BATS_FILE_TMPDIR" || return 1; }
in_chromium() {
  python3 "$root/tests/tools/browser.py" || skip "no Chromium: apt-get install chromium"
  python3 "$root/tests/tools/report_page.py" "$@" ${SCREENSHOTS:-}
}

@test "pm-report: help" {
  shows_help pm-report
}

@test "pm-report: a run ends with its page, which names no address and holds no markup of others" {
  grep -q 'report  run/report.html' log
  [ "$(grep -o '<script' run/report.html | wc -l)" -eq 3 ]
  refute grep -qE '<script>alert|</title><script' run/report.html
  grep -q '&lt;script&gt;alert(1)' run/report.html
  grep -q '&lt;script&gt;alert(2)' run/report.html
  refute grep -qE '(src|href)="?(http|//)' run/report.html
  grep -q "Content-Security-Policy\" content=\"default-src 'none'" run/report.html
  [ "$(stat -c %s run/report.html)" -lt 8388608 ]
  # What is read has its hash in the record; every file of the run is linked to.
  python3 - <<'P'
import json
record = json.load(open("run/report.json"))
assert record["decision"] == "accept" and record["shown"] in record["candidates"] and record["viewer"]["frames"] == 4, record
names = [i["path"] for i in record["provenance"]["inputs"]]
for name in ("plan.json", "inventory.json", "evidence.json", "state.h5", "screen/round0.json", "final.mp4"):
    assert name in names, name
assert record["provenance"]["outputs"][0]["without"] == "runtime"
P
}

@test "pm-report: the same records give the same bytes, whatever the threads, and nothing is rewritten" {
  fingerprint run >before
  "$bin/pm-report" --run run --threads 1
  "$bin/pm-report" --run run --threads 3
  fingerprint run >after
  cmp before after
}

@test "pm-report: a refused run shows the best and why; one that did not end what there is" {
  grep -q 'No candidate was admitted' refused/report.html
  grep -q '"decision": "fail"' refused/report.json
  grep -q 'best.mp4' refused/report.json
  "$bin/pm-report" --run failed
  grep -q 'not finished' failed/report.html
  grep -q '"decision": "unfinished"' failed/report.json
}

@test "pm-report: limits leave out what they say" {
  "$bin/pm-report" --run run --out small/page.html --viewer 0 --videos 0
  grep -q '"viewer": null' small/page.json
  grep -q 'too large for the page' small/page.json
  [ "$(stat -c %s small/page.html)" -lt "$(stat -c %s run/report.html)" ]
}

@test "pm-report: what is no run is refused, and nothing is written" {
  fails_with 2 "$bin/pm-report" -- "--run is required"
  fails_with 2 "$bin/pm-report" --run run --out page.txt -- .html
  mkdir -p empty
  fails_with 3 "$bin/pm-report" --run empty -- "no spec/render.json"
  fails_with 3 "$bin/pm-report" --run nowhere -- nowhere
  rm -rf broken
  cp -r run broken
  rm broken/report.*
  sed -i 's/"rank": 1/"rank": "first"/' broken/screen/round0.json
  fails_with 3 "$bin/pm-report" --run broken -- broken/screen/round0.json rank
  [ ! -e broken/report.html ]
  rm -rf broken
  cp -r run broken
  head -c 100 run/rollouts/"$(python3 -c 'import json; print(json.load(open("run/report.json"))["shown"])')".h5 >cut
  cp cut broken/rollouts/"$(python3 -c 'import json; print(json.load(open("run/report.json"))["shown"])')".h5
  fails_with 3 "$bin/pm-report" --run broken -- broken/rollouts
}

@test "pm-report: an index has a row for every run, of failed ones as well, and writes the report that is missing" {
  rm -f failed/report.*
  mkdir -p nothing
  "$bin/pm-report" index run refused failed nothing --out index.html
  [ "$(grep -c '<tr><td' index.html)" -eq 4 ]
  [ -s failed/report.html ]
  grep -q 'href="refused/report.html"' index.html
  refute grep -q '<script' index.html
  in_chromium index index.html
}

@test "pm-report: pages of an accepted, a refused and an unfinished run in Chromium: nothing is asked for, everything has a name" {
  "$bin/pm-report" --run failed
  in_chromium accepted run/report.html
  in_chromium refused refused/report.html
  in_chromium unfinished failed/report.html
}
