#!/usr/bin/env python3
"""Compares all that runs of the examples leave, byte for byte, between two builds.

  artifacts.py run FOLDER [NAME ...]    in a built tree: runs the examples (all, or these) coarsely below FOLDER
  artifacts.py compare BEFORE AFTER     prints every file that differs and, for records, the fields; exits 1 if any does

What is not part of an artifact's identity is left out: `runtime` in records, and hashes of records that hold it.
"""

import glob
import hashlib
import json
import os
import subprocess
import sys

SETTINGS = (
    "grid.n=32 time.frames=12 time.substep_dt=4e-4 time.min_substep_dt=1e-4 render.width=320 render.height=320"
)


def run(folder, names):
    examples = names or sorted(
        os.path.basename(path)[: -len(".json")]
        for path in glob.glob("examples/*.json")
        if json.load(open(path)).get("schema") == "physmas/example/1"
    )
    for name in examples:
        done = subprocess.run(
            ["make", "run", f"EXAMPLE={name}", f"RUN={folder}/{name}", f"SET={SETTINGS}", "DEFAULTS=", "THREADS=1"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        print(f"{name}: {'accepted' if done.returncode == 0 else f'make exits with {done.returncode}'}", flush=True)
        if done.returncode not in (0, 2):
            print(done.stdout)


def record_of(path):
    """A record without what may differ between two equal runs."""
    record = json.load(open(path))
    record.pop("runtime", None)
    return record


def differences(before, after, where, same, found):
    """same: pairs of hashes of files that are equal but for run times."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted(set(before) | set(after)):
            if key not in before or key not in after:
                found.append(f"{where}/{key}: only {'after' if key in after else 'before'}")
            else:
                differences(before[key], after[key], f"{where}/{key}", same, found)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for i, (a, b) in enumerate(zip(before, after)):
            differences(a, b, f"{where}/{i}", same, found)
    elif before != after and (not isinstance(before, str) or (before, after) not in same):
        found.append(f"{where}: {before} -> {after}"[:200])


def files_of(folder):
    paths = []
    for root, folders, files in os.walk(folder):
        folders[:] = [f for f in folders if f != ".stamps"]
        paths += [os.path.relpath(os.path.join(root, f), folder) for f in files]
    return sorted(paths)


def sha256(path):
    return hashlib.sha256(open(path, "rb").read()).hexdigest()


def compare(before, after):
    first, second = files_of(before), files_of(after)
    report = {p: [f"only {'after' if p in second else 'before'}"] for p in set(first) ^ set(second)}
    unequal = []
    for path in sorted(set(first) & set(second)):
        a, b = f"{before}/{path}", f"{after}/{path}"
        if open(a, "rb").read() != open(b, "rb").read():
            unequal.append(path)
    # A record that holds hashes of records with run times is equal once those are found to be.
    same, known = set(), -1
    while len(same) != known:
        known = len(same)
        for path in unequal:
            a, b = f"{before}/{path}", f"{after}/{path}"
            report[path] = ["bytes differ"]
            if path.endswith(".json"):
                report[path] = []
                differences(record_of(a), record_of(b), "", same, report[path])
            if not report[path]:
                same.add((sha256(a), sha256(b)))
    for path in sorted(report):
        for line in report[path]:
            print(f"{path}: {line}")
    count = sum(1 for lines in report.values() if lines)
    print(f"{len(first)} and {len(second)} files, {count} differ")
    return 1 if count or not first else 0


if __name__ == "__main__":
    if len(sys.argv) >= 3 and sys.argv[1] == "run":
        run(sys.argv[2], sys.argv[3:])
    elif len(sys.argv) == 4 and sys.argv[1] == "compare":
        sys.exit(compare(sys.argv[2], sys.argv[3]))
    else:
        sys.exit(__doc__)
