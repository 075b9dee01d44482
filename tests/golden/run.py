#!/usr/bin/env python3
"""Holds the tools against the golden recomputation: run.py BIN MAKE_FIXTURE DATA FOLDER

For every generated scene: pm-material, pm-candidates, and round after round pm-screen and pm-candidates --repair, in
FOLDER; every number that they write is compared with what paper.py and paper_candidates.py make of the same records. Execution
and render records are made up. Prints the disagreements and exits 1 when there are any, or when the scenes do not reach
an outcome that they must reach.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True  # the sources' folder may be read-only

import paper_candidates as pc
import scenes as generated

# Two implementations of log10 and pow may differ in the last bits; sums are in the same order.
TOLERANCE = 1e-12

REQUIRED = (
    [
        "expected: " + s
        for s in ["applied", "empty set", "only mode is expected", "only P below 0.18", "only above the cap"]
    ]
    + [
        "multi-view: " + s
        for s in [
            "applied",
            "several eligible",
            "only confidence",
            "only views",
            "only top probability",
            "only v is not expected",
            "only R(v) below 0.50",
            "only R(v) below R(m) + 0.10",
            "only P(v) below 0.20",
            "only P(m) above 1.50 P(v)",
            "only P(m) - P(v) above 0.18",
        ]
    ]
    + ["strong record: " + s for s in ["applied", "only views", "only confidence", "only total", "only maximum"]]
    + [
        "elastic-solid: " + s
        for s in [
            "applied",
            "applied without expected labels",
            "only already elastic",
            "only not structural",
            "only fraction below 0.50",
            "only no strong record",
        ]
    ]
    + ["fallback", "mask: sentinel", "mask: floor", "mask: stored"]
    + ["whole object: " + s for s in ["authored", "crop", "fallback"]]
    + [name + ": emitted" for name in pc.INITIAL]
    + [name + ": not retained" for name in pc.INITIAL[2:]]
    + [
        name + ": not applicable"
        for name in pc.INITIAL
        if name not in ("posterior", "soft", "stiff", "uncertainty-sweep")
    ]
    + ["target-impact: " + s for s in ["S row", "C row", "neither", "residual row"]]
    + [
        "alternative: another label",
        "alternative: the stored label itself",
        "bonded: one object",
        "bonded: several objects",
    ]
    + ["repair %s: emitted" % name for name in pc.REPAIRS]
    + ["route: " + name for name in pc.REPAIRS]
    + ["repair %s: support row" % name for name in pc.REPAIRS if name != "solver-stability"]
    + ["repair %s: cohesive row" % name for name in ("elastic-cohesion", "higher-cohesion", "role-balanced")]
    + [
        "gate %s: %s" % (g, r)
        for g in ("plan", "process", "numerical", "spread", "flattening", "support")
        for r in ("passed", "failed")
    ]
    + ["decision in round %d: %s" % (k, d) for k in (0, 1) for d in ("accept", "repair")]
    + ["decision in round 2: fail", "audit: failed", "repairs: none left"]
)

bin_folder, make_fixture, data, folder = map(os.path.abspath, sys.argv[1:5])
disagreements = []
compared = 0


def write(path, document):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w") as f:
        json.dump(document, f)


def read(path):
    with open(path) as f:
        return json.load(f)


def tool(name, *arguments, codes=(0,)):
    program = make_fixture if name == "make_fixture" else os.path.join(bin_folder, name)
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in codes:
        sys.exit("%s ended with %d: %s (in %s)" % (name, done.returncode, done.stderr.strip(), os.getcwd()))
    return done.returncode


def same(where, ours, golden):
    """Compares numbers, texts, lists and dictionaries (in order)."""
    global compared
    compared += 1
    if isinstance(golden, dict):
        same(where + " (keys)", list(ours), list(golden))
        for key in golden:
            if key in ours:
                same("%s/%s" % (where, key), ours[key], golden[key])
    elif isinstance(golden, (list, tuple)):
        if len(ours) != len(golden):
            disagreements.append("%s: the tool has %r, the script %r" % (where, ours, golden))
            return
        for i, (a, b) in enumerate(zip(ours, golden)):
            same("%s/%d" % (where, i), a, b)
    elif isinstance(golden, float) and not isinstance(ours, (str, type(None))):
        if not abs(ours - golden) <= TOLERANCE * max(1.0, abs(golden)):
            disagreements.append("%s: the tool has %r, the script %r" % (where, ours, golden))
    elif ours != golden:
        disagreements.append("%s: the tool has %r, the script %r" % (where, ours, golden))


def compare_evidence(where, evidence, golden, whole):
    for row, psi in zip(evidence["rows"], golden):
        at = "%s %s" % (where, row["key"])
        same(at + " sources", row["sources"], psi["sources"])
        same(at + " scores", row["scores"], psi["scores"])
        same(at + " fallback", row["fallback"], psi["fallback"])
        same(at + " posterior", {e["label"]: e["probability"] for e in row["posterior"]}, psi["P"])
        same(at + " guards", [[g["name"], g["applied"], g["label"]] for g in row["guards"]], psi["guards"])
        same(at + " label", [row["label"], row["confidence"]], [psi["label"], psi["confidence"]])
        same(
            at + " E",
            {k: row["E"][k] for k in ("log10", "mean", "spread", "uncertainty", "dispersion", "records")},
            {
                "log10": psi["e"],
                "mean": psi["e_mean"],
                "spread": psi["spread"],
                "uncertainty": psi["a"],
                "dispersion": psi["sigma_e"],
                "records": psi["E_records"],
            },
        )
        same(
            at + " nu",
            {k: row["nu"][k] for k in ("value", "mean", "dispersion", "records")},
            {"value": psi["nu"], "mean": psi["nu_mean"], "dispersion": psi["sigma_nu"], "records": psi["nu_records"]},
        )
        same(at + " entropy", row["entropy"], psi["H"])
        same(at + " part confidence", row["part_confidence"], psi["gamma"])
    record = evidence["whole_object"]
    same(where + " whole object", [record[k] for k in ("source", "label", "branch", "E", "nu", "rho")], list(whole))


def compare_candidates(where, round_, new):
    ids = read("candidates/round%d.json" % round_)["candidates"]
    same("%s round %d" % (where, round_), ids, list(new))
    for id_ in ids:
        if id_ not in new:
            continue
        record, golden = read("candidates/%s.json" % id_), new[id_]
        at = "%s %s" % (where, id_)
        same(
            at + " rows",
            {r["key"]: {k: r[k] for k in ("branch", "E", "nu", "rho", "label")} for r in record["rows"]},
            golden["rows"],
        )
        same(at + " projection", record["controls"]["projection"], golden["projection"])
        same(at + " retention", record["controls"]["retention"], golden["retention"])
        same(at + " base confidence", record["base_confidence"], golden["base"])
        same(at + " parent", record["parent"], golden["parent"])
        step = record["timestep"]
        same(at + " step", [step["target"], step["substeps"], step["dt"]], list(golden["step"]))


def execute(scene, ids):
    for id_ in ids:
        done = generated.outcome(scene, id_)
        with open("candidates/%s.json" % id_, "rb") as f:
            digest = hashlib.sha256(f.read()).hexdigest()
        tokens = done["execution"]["tokens"]
        os.makedirs("rollouts", exist_ok=True)
        with open("rollouts/%s.h5" % id_, "w") as f:
            f.write("in the place of a rollout")
        write(
            "rollouts/%s.json" % id_,
            {
                "schema": "physmas/execution/1",
                "provenance": {
                    "tool": "golden",
                    "version": "1",
                    "options": {},
                    "inputs": [{"path": "../candidates/%s.json" % id_, "sha256": digest}],
                },
                "candidate": id_,
                "process": {"exit": done["execution"]["exit"], "signal": done["execution"]["signal"]},
                "numerical": {
                    "status": "diverged" if tokens else "stable",
                    "error_tokens": tokens,
                    "first_bad_step": None,
                    "max_speed": 0,
                    "J_range": [1, 1],
                    "mass": 1,
                    "momentum": {"start": [0, 0, 0], "end": [0, 0, 0]},
                    "energy": {"kinetic": [], "elastic": [], "potential": []},
                    "particles_outside": 0,
                },
                "steps": {"per_frame": 1, "total": 1, "dt": 0.04},
                "frames": generated.FRAMES,
                "omitted": [],
                "runtime": {},
            },
        )
        if done["video"]:
            os.makedirs("videos", exist_ok=True)
            shutil.copy("../video.mp4", "videos/%s.mp4" % id_)
        write(
            "videos/%s.json" % id_,
            {
                "schema": "physmas/render/1",
                "candidate": id_,
                "video": id_ + ".mp4" if done["video"] else None,
                "frames_written": generated.FRAMES,
                "file_size": done["file_size"],
                "width": 64,
                "height": 64,
                "frames": [
                    {"frame": f["frame"], "box": f["box"], "area": 0, "dark_ratio": f["dark"]} for f in done["frames"]
                ],
                "omitted": [],
                "runtime": {},
            },
        )


def compare_screen(where, round_, golden):
    record = read("screen/round%d.json" % round_)
    at = "%s screen %d" % (where, round_)
    names = ["video", "part_confidence", "diversity", "role", "base", "density", "solver"]
    same(at + " order", [c["id"] for c in record["candidates"]], list(golden["screened"]))
    for c in record["candidates"]:
        expected = golden["screened"].get(c["id"])
        if expected is None:
            continue
        here = "%s %s" % (at, c["id"])
        same(here + " features", [c["features"][n] for n in names], expected["features"])
        same(here + " score", [c["penalty"], c["score"]], [expected["penalty"], expected["score"]])
        same(here + " gates", {g["name"]: g["passed"] for g in c["gates"]}, expected["gates"])
        same(here + " admitted", c["admitted"], expected["admitted"])
    decision = golden["decision"]
    same(at + " ranking", [c["id"] for c in sorted(record["candidates"], key=lambda c: c["rank"])], decision["ranked"])
    repair = record["repair"] or {"base": None, "routes": []}
    same(
        at + " decision",
        [record["decision"], record["accepted"], repair["base"], repair["routes"]],
        [decision["decision"], decision["accepted"], decision["base"], decision["routes"]],
    )


def run_scene(number, scene):
    where = "scene %d (seed %d)" % (number, scene["seed"])
    evidence, whole, rounds = generated.golden(scene, set())
    os.makedirs("scene-%d" % number)
    os.chdir("scene-%d" % number)
    bundle = read(os.path.join(data, "scene.json"))
    bundle["run"].update(scene["run"])
    write("scene.json", bundle)
    write("inventory.json", scene["inventory"])
    write("records.json", scene["records"])
    write("plan.json", scene["plan"])
    tool("make_fixture", "masks", "inventory.json", "masks.h5", scene["mask_confidence"])
    tool("make_fixture", "state", "inventory.json", "state.h5", *scene["counts"])
    tool(
        "pm-material",
        "--scene",
        "scene.json",
        "--inventory",
        "inventory.json",
        "--masks",
        "masks.h5",
        "--state",
        "state.h5",
        "--predictor",
        "records.json",
        "--out",
        "evidence.json",
    )
    compare_evidence(where, read("evidence.json"), evidence, whole)
    common = [
        "--scene",
        "scene.json",
        "--inventory",
        "inventory.json",
        "--plan",
        "plan.json",
        "--evidence",
        "evidence.json",
    ]
    for k, golden in enumerate(rounds):
        repair = ["--repair", "screen/round%d.json" % (k - 1)] if k else []
        tool("pm-candidates", *common, "--state", "state.h5", "--out", "candidates", *repair)
        compare_candidates(where, k, golden["new"])
        execute(scene, read("candidates/round%d.json" % k)["candidates"])
        code = tool(
            "pm-screen",
            *common,
            "--candidates",
            "candidates",
            "--rollouts",
            "rollouts",
            "--videos",
            "videos",
            "--round",
            k,
            "--out",
            "screen/round%d.json" % k,
            codes=(0, 6)
        )
        same(where + " exit code", code, 6 if golden["decision"]["decision"] == "fail" else 0)
        compare_screen(where, k, golden)
    os.chdir("..")


def main():
    os.makedirs(folder, exist_ok=True)
    os.chdir(folder)
    tool("make_fixture", "video", "video.mp4", generated.FRAMES)
    scenes, seen = generated.all_scenes()
    for number, scene in enumerate(scenes):
        run_scene(number, scene)
    missing = [what for what in REQUIRED if what not in seen]
    for line in disagreements[:40]:
        print(line)
    for what in missing:
        print("no scene reaches: " + what)
    print(
        "%d scenes, %d comparisons, %d disagreements, %d of %d required outcomes reached"
        % (len(scenes), compared, len(disagreements), len(REQUIRED) - len(missing), len(REQUIRED))
    )
    sys.exit(1 if disagreements or missing else 0)


main()
