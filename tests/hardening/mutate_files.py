#!/usr/bin/env python3
"""Cuts and mutates the files of a run, one or a whole folder at a time, and gives them to the tools that read them.

    mutate_files.py BIN FOLDER TRIES [SEED]    prints a row: what, tried, failed, seconds; exit code 1 where a tool failed

Right is an end with exit code 0, 2, 3 or 6 (of a replay 0, 3 or 4) in time; with 2, 3 and 4 in one line on stderr that begins with the tool's name, after
notes; no temporary file; and no other answers from a replay. What failed is kept in FOLDER/failed-N with the command.
"""
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SECONDS, MEMORY = 60, 8 << 30
TOKENS = [b"0", b"-1", b"1e308", b"nan", b"inf", b"18446744073709551615", b"4294967296", b"null", b"{}", b"[]", b'""', b"\xff" * 4, b"\0" * 8,
          b"\n", b" ", b"2147483648", b"../", b"/dev/null", b"%s%n"]

binaries, folder, tries = os.path.abspath(sys.argv[1]), sys.argv[2], int(sys.argv[3])
chance = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
shutil.rmtree(folder, ignore_errors=True)
os.makedirs(folder)
os.chdir(folder)


def tool(name, *arguments):
    return [binaries + "/" + name, *arguments, "--threads", "1"]


def prepare():
    """A run of one candidate in `base`, and its views with cameras of COLMAP and of nerfstudio."""
    os.mkdir("base")
    os.chdir("base")
    with open(ROOT + "/tests/data/tiny.json") as file:
        example = json.load(file)
    example["run"] = {"grid": {"n": 24}, "render": {"width": 32, "height": 32}, "screening": {"initial": 2, "rounds": 1, "tau": -9},
                      "time": {"frames": 3, "substep_dt": 8e-4, "min_substep_dt": 2e-4, "max_substeps": 200}}
    with open("example.json", "w") as file:
        json.dump(example, file)
    quiet = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.run(tool("pm-scene", "synth", "example.json", "--out", "bundle"), **quiet)
    with open("bundle/scene.json") as file:
        views = json.load(file)["views"]
    os.makedirs("colmap")
    os.makedirs("images")
    with open("colmap/cameras.txt", "w") as cameras, open("colmap/images.txt", "w") as images:
        frames = []
        for i, view in enumerate(views):
            camera = view["camera"]
            name = os.path.basename(view["image"])
            shutil.copy("bundle/" + view["image"], "images/" + name)
            cameras.write("%d PINHOLE %d %d %r %r %r %r\n" % (i + 1, camera["width"], camera["height"], camera["fx"], camera["fy"], camera["cx"], camera["cy"]))
            m = camera["world_to_camera"]
            m = [m[k:k + 4] for k in (0, 4, 8)] if not isinstance(m[0], list) else m[:3]
            w = max(1e-6, 1 + m[0][0] + m[1][1] + m[2][2]) ** 0.5 / 2
            q = [w, (m[2][1] - m[1][2]) / 4 / w, (m[0][2] - m[2][0]) / 4 / w, (m[1][0] - m[0][1]) / 4 / w]
            images.write("%d %r %r %r %r %r %r %r %d %s\n\n" % (i + 1, *q, m[0][3], m[1][3], m[2][3], i + 1, name))
            frames.append({"name": view["name"], "image": name, "camera": camera})
        with open("cameras.json", "w") as file:
            json.dump(frames, file, indent=1)
    for command in COMMANDS[:8]:
        subprocess.run(tool(*command[0]), **quiet)
    os.rename("evidence.json", "kept.json")
    record_exchanges(quiet)
    os.rename("evidence.json", "asked.json")
    os.rename("kept.json", "evidence.json")
    os.chdir("..")


def record_exchanges(quiet):
    """What a chat model says of the rows, in exchanges/."""
    server = subprocess.Popen([sys.executable, "-B", ROOT + "/tests/tools/server.py", "port", "requests", "good"], stdin=subprocess.PIPE, **{k: quiet[k] for k in ("stdout", "stderr")})
    try:
        while not os.path.exists("port") or not os.path.getsize("port"):
            time.sleep(0.02)
        with open("port") as file:
            url = "http://127.0.0.1:" + file.read().strip()
        subprocess.run(tool("pm-material", *scene, "--inventory", "inventory.json", "--masks", "masks.h5", *state, "--out", "evidence.json", "--agent", url, "--model", "tester"), **quiet)
    finally:
        server.stdin.close()
        server.wait()


scene = ["--scene", "bundle/scene.json"]
state = ["--state", "state.h5"]
# A command, and what of its inputs is mutated: files, or a folder as a whole.
COMMANDS = [
    (["pm-ground", *scene, "--out", "."], ["bundle/scene.json", "bundle/inventory.json", "bundle/views/front.png", "bundle/"]),
    (["pm-lift", *scene, "--inventory", "inventory.json", "--masks", "masks.h5", "--out", "state.h5"],
     ["inventory.json", "masks.h5", "bundle/gaussians.ply"]),
    (["pm-material", *scene, "--inventory", "inventory.json", "--masks", "masks.h5", *state, "--out", "evidence.json"], ["masks.h5", "state.h5"]),
    (["pm-candidates", *scene, "--inventory", "inventory.json", "--plan", "plan.json", "--evidence", "evidence.json", *state, "--out", "candidates"],
     ["plan.json", "evidence.json", "state.h5", "inventory.json"]),
    (["pm-simulate", *scene, *state, "--candidate", "candidates/hard-support-bonded.json", "--out", "rollouts/hard-support-bonded.h5"],
     ["candidates/hard-support-bonded.json", "state.h5"]),
    (["pm-simulate", *scene, *state, "--candidate", "candidates/posterior.json", "--out", "rollouts/posterior.h5"], ["candidates/posterior.json"]),
    (["pm-render", *scene, *state, "--rollout", "rollouts/hard-support-bonded.h5", "--out", "videos/hard-support-bonded.mp4"],
     ["rollouts/hard-support-bonded.h5", "rollouts/hard-support-bonded.json", "state.h5", "bundle/gaussians.ply"]),
    (["pm-render", *scene, *state, "--rollout", "rollouts/posterior.h5", "--out", "videos/posterior.mp4"], ["rollouts/posterior.h5"]),
    (["pm-screen", *scene, "--plan", "plan.json", "--evidence", "evidence.json", "--inventory", "inventory.json", "--candidates", "candidates",
      "--rollouts", "rollouts", "--videos", "videos", "--round", "0", "--out", "screen/round0.json"],
     ["candidates/round0.json", "rollouts/posterior.json", "videos/hard-support-bonded.json", "videos/hard-support-bonded.mp4", "plan.json"]),
    (["pm-scene", "import", "bundle/gaussians.ply", "--prompt", "it falls", "--views", "images", "--cameras", "colmap", "--out", "imported"],
     ["colmap/cameras.txt", "colmap/images.txt", "colmap/", "colmap/", "images/"]),
    (["pm-scene", "import", "bundle/gaussians.ply", "--prompt", "it falls", "--views", "images", "--cameras", "cameras.json", "--out", "imported"],
     ["cameras.json", "images/"]),
    (["pm-scene", "info", "bundle/gaussians.ply"], ["bundle/gaussians.ply"]),
    (["pm-material", *scene, "--inventory", "inventory.json", "--masks", "masks.h5", *state, "--out", "replayed.json", "--agent", "replay:exchanges", "--model", "tester"],
     ["exchanges/", "exchanges/", "exchanges/material_lollipop_candy_1.json", "exchanges/material_lollipop_stick_1.json"]),
]


def mutated(data):
    data = bytearray(data)
    for _ in range(1 + chance.randrange(5)):
        at = chance.randrange(len(data) + 1)
        how = chance.randrange(7)
        token = chance.choice(TOKENS)
        if how == 0 and at < len(data):
            data[at] ^= 1 << chance.randrange(8)
        elif how == 1:
            data[at:at + 1 + chance.randrange(16)] = b""
        elif how == 2:
            data[at:at] = token
        elif how == 3:
            data[at:at + len(token)] = token
        elif how == 4:
            piece = chance.randrange(len(data) + 1)
            data[at:at] = data[piece:piece + 64]
        elif how == 5:
            data = data[:at]
        else:
            data[at:at + 4] = bytes(chance.randrange(256) for _ in range(4))
    return bytes(data)


def mutate(path):
    with open(path, "rb") as file:
        data = file.read()
    with open(path, "wb") as file:
        file.write(mutated(data))


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def complaint(command):
    """What is wrong with how the command ended; empty: nothing."""
    try:
        process = subprocess.run(tool(*command), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=SECONDS, preexec_fn=limits)
    except subprocess.TimeoutExpired:
        return "no end after %d s" % SECONDS
    errors = process.stderr.decode(errors="replace").splitlines()
    replay = "replay:exchanges" in command
    if process.returncode not in ((0, 3, 4) if replay else (0, 2, 3, 6)):
        return "exit code %d: %s" % (process.returncode, errors[-1:])
    told = [line for line in errors if not line.startswith((command[0] + ": note:", command[0] + ": warning:", command[0] + ": info:"))]
    if process.returncode in (2, 3, 4) and (len(told) != 1 or not told[0].startswith(command[0] + ": error: ")):
        return "exit code %d without one line: %s" % (process.returncode, told)
    if process.returncode == 0 and told:
        return "lines of somebody else: %s" % told
    if replay and process.returncode == 0:
        with open("asked.json") as asked, open("replayed.json") as replayed:
            if json.load(asked)["rows"] != json.load(replayed)["rows"]:
                return "an answer that the model did not give"
    left = [os.path.join(d, n) for d, _, names in os.walk(".") for n in names if n.startswith(".") and ".tmp" in n]
    return "left: %s" % left if left else ""


begin = time.time()
prepare()
failed = 0
for attempt in range(tries):
    command, targets = COMMANDS[attempt % len(COMMANDS)]
    target = chance.choice(targets)
    shutil.rmtree("try", ignore_errors=True)
    shutil.copytree("base", "try")
    os.chdir("try")
    if target.endswith("/"):
        files = [os.path.join(d, n) for d, _, names in os.walk(target) for n in names]
        for path in sorted(files):
            if chance.random() < 0.5:
                mutate(path)
            elif chance.random() < 0.1:
                os.remove(path)
    else:
        mutate(target)
    before = os.path.join("..", "failed-%d" % attempt)
    shutil.copytree(".", before)
    wrong = complaint(command)
    os.chdir("..")
    if wrong:
        failed += 1
        print("failed-%d: %s with %s: %s" % (attempt, " ".join(command[:2]), target, wrong), file=sys.stderr)
    else:
        shutil.rmtree("failed-%d" % attempt)
print("mutated files and folders\t%d files\t%d\t%.0f" % (tries, failed, time.time() - begin))
sys.exit(1 if failed else 0)
