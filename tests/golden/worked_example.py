#!/usr/bin/env python3
"""The worked example of docs/method.md, as the tools print it: worked_example.py BIN MAKE_FIXTURE DATA FOLDER

Runs pm-material, pm-candidates, pm-screen and a repair round on DATA in FOLDER and prints what becomes of one row as
Markdown.
tests/cli/golden.bats holds the section of docs/method.md against it.
"""

import json
import os
import shutil
import subprocess
import sys

KEY = "cake/sponge"
bin_folder, make_fixture, data, folder = map(os.path.abspath, sys.argv[1:5])


def run(program, *arguments):
    subprocess.run([program, *arguments], check=True)


def tool(name, *arguments):
    run(os.path.join(bin_folder, name), "--scene", "scene.json", "--inventory", "inventory.json", *arguments)


def read(path):
    with open(path) as f:
        return json.load(f)


def text(x):
    """Up to six significant digits, as people write numbers."""
    if x is None:
        return ""
    return "%.6g" % x if abs(x) < 1e6 else "%.4e" % x


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


os.makedirs(folder)
os.chdir(folder)
for name in ("inventory.json", "plan.json", "material-records.json"):
    shutil.copy(os.path.join(data, name), name)
scene = read(os.path.join(data, "scene.json"))
scene["run"]["screening"] = {"initial": 10}
with open("scene.json", "w") as f:
    json.dump(scene, f)
run(make_fixture, "masks", "inventory.json", "masks.h5", "0.9")
run(make_fixture, "state", "inventory.json", "state.h5", "3", "4", "2", "1")
run(make_fixture, "video", "video.mp4", "3")
tool(
    "pm-material",
    "--masks",
    "masks.h5",
    "--state",
    "state.h5",
    "--predictor",
    "material-records.json",
    "--out",
    "evidence.json",
)
common = ["--plan", "plan.json", "--evidence", "evidence.json"]
tool("pm-candidates", *common, "--state", "state.h5", "--out", "candidates")
ids = read("candidates/round0.json")["candidates"]
for id_ in ids:
    os.makedirs("rollouts", exist_ok=True)
    os.makedirs("videos", exist_ok=True)
    run(make_fixture, "execution", "candidates/%s.json" % id_, "rollouts/%s.json" % id_)
    # The picture of the foreground doubles: the spread gate fails and asks for the cohesion repairs.
    run(make_fixture, "render", id_, "video.mp4", "videos/%s.json" % id_, "3", "20", "11")
tool(
    "pm-screen",
    *common,
    "--candidates",
    "candidates",
    "--rollouts",
    "rollouts",
    "--videos",
    "videos",
    "--round",
    "0",
    "--out",
    "screen.json"
)
tool("pm-candidates", *common, "--state", "state.h5", "--out", "candidates", "--repair", "screen.json")

row = next(r for r in read("evidence.json")["rows"] if r["key"] == KEY)
labels = list(row["scores"])
print("Scores by source, their sums s and the posterior P:\n")
print(
    table(
        ["source"] + labels,
        [[name] + [text(scores.get(m)) for m in labels] for name, scores in row["sources"].items()]
        + [["s"] + [text(row["scores"][m]) for m in labels]]
        + [["P"] + [text({e["label"]: e["probability"] for e in row["posterior"]}[m]) for m in labels]],
    )
)
print("\nGuards, with the comparisons that failed:\n")
rows = []
for guard in row["guards"]:
    tests = guard["measured"].get("tests", []) + [t for r in guard["measured"].get("records", []) for t in r["tests"]]
    failed = ["%s (%s; limit: %s)" % (t["test"], t["value"], t["limit"]) for t in tests if not t["passed"]]
    rows.append([guard["name"], "applied" if guard["applied"] else "not applied", guard["label"], "; ".join(failed)])
print(table(["guard", "outcome", "label after it", "failed"], rows))
print("\nStatistics:\n")
E, nu = row["E"], row["nu"]
print(
    table(
        ["quantity", "value"],
        [
            ["ē, s^e, ā", "%s, %s, %s" % tuple(text(E[k]) for k in ("mean", "spread", "uncertainty"))],
            ["e_post, E_post", "%s, %s Pa" % (text(E["log10"]), text(10 ** E["log10"]))],
            ["H, σ^e", "%s, %s" % (text(row["entropy"]), text(E["dispersion"]))],
            ["ν_post, σ^ν", "%s, %s" % (text(nu["value"]), text(nu["dispersion"]))],
            ["γ^mask, γ^part", "%s, %s" % (text(row["mask_confidence"]), text(row["part_confidence"]))],
        ],
    )
)
print("\nThe row in every candidate:\n")
rows = []
for id_ in ids + read("candidates/round1.json")["candidates"]:
    r = next(r for r in read("candidates/%s.json" % id_)["rows"] if r["key"] == KEY)
    rows.append([id_, r["branch"], text(r["E"]), text(r["nu"]), text(r["rho"])])
print(table(["candidate", "branch", "E (Pa)", "ν", "ρ"], rows))
omitted = [o for n in (0, 1) for o in read("candidates/round%d.json" % n).get("omitted", [])]
if omitted:
    print("\nNot emitted: " + "; ".join("%s (%s)" % (o["what"], o["why"]) for o in omitted) + ".")
