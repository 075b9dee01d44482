#!/usr/bin/env bats
# The page of a study in a browser, from the manifest to the rates.
bats_require_minimum_version 1.5.0
load tiny

have_chromium() { python3 "$root/tests/tools/browser.py"; }

setup_file() {
  have_chromium || return 0
  make_tiny_run
  cd "$BATS_FILE_TMPDIR/run"
  render --out run.mp4
  # Six methods on three cases; of the second case two results failed, one per study.
  python3 - <<'PY'
import json
methods = ["alphaphys", "betaphys", "gammaphys", "deltaphys", "epsilonphys", "zetaphys"]
def results(failed=()):
    return {m: {"status": "failed", "reason": "out of memory"} if m in failed else {"status": "done", "video": "run.mp4"}
            for m in methods}
cases = [
    {"id": "one", "kind": "multi-part", "prompt": "it </script> falls", "profiles": ["Jelly"], "results": results()},
    {"id": "two", "kind": "multi-part", "prompt": "a hand presses down on the top of the cake, slowly at first, then harder",
     "profiles": ["Metal"], "results": results(("betaphys", "zetaphys"))},
    {"id": "three", "kind": "multi-object", "prompt": "the hammer hits the cake", "objects": ["hammer", "cake"], "results": results()}]
json.dump({"schema": "physmas/evaluation/1", "methods": [{"id": m, "name": m.title()} for m in methods],
           "comparison": methods[:5], "ablation": ["deltaphys", "zetaphys", "epsilonphys"],
           "required": ["upr"], "cases": cases}, open("evaluation.json", "w"))
PY
}
setup() {
  have_chromium || skip "no Chromium: apt-get install chromium"
  enter_tiny_run
}

# STUDY: the page in the browser, then the rates of what the respondents chose.
whole_study() {
  "$bin/pm-eval" study --manifest evaluation.json --study "$1" --seed s --out study
  python3 "$root/tests/tools/study_page.py" study "${SCREENSHOTS:-answers}"
  "$bin/pm-eval" upr --key study/key.json --answers "${SCREENSHOTS:-answers}"/answers-{Ada,Ben,Eve}.json --out upr.json
  python3 - "${SCREENSHOTS:-answers}" <<'PY'
import json, sys
key, upr = json.load(open("study/key.json")), json.load(open("upr.json"))
codes = {c["id"]: c["codes"] for c in key["cases"]}
counts = {c: dict.fromkeys(key["methods"], 0) for c in codes}
for name in ("Ada", "Ben", "Eve"):
    for a in json.load(open(f"{sys.argv[1]}/answers-{name}.json"))["answers"]:
        counts[a["case"]][codes[a["case"]][a["choice"]]] += 1
assert upr["respondents"] == 3 and {c["id"]: c["counts"] for c in upr["cases"]} == counts, (upr, counts)
PY
}

@test "a five-alternative study in Chromium: videos play, keys and touch choose, the saved answers become rates" {
  whole_study comparison
}

@test "a three-alternative study in Chromium" {
  whole_study ablation
}
