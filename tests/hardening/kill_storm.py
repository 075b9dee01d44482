#!/usr/bin/env python3
"""Kills runs at random moments, and looks whether a rerun ends with the bytes of a run that nobody disturbed.

    kill_storm.py BIN FOLDER KILLS [SEED]    prints a row: what, tried, failed, seconds; exit code 1 where a rerun was wrong

Two of three kills hit make and all that it started at once, as a machine that loses its power would; the third hits one tool,
and make goes on.
"""
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
KILLS_PER_RERUN = 10

binaries, folder, kills = os.path.abspath(sys.argv[1]), sys.argv[2], int(sys.argv[3])
chance = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
shutil.rmtree(folder, ignore_errors=True)
os.makedirs(folder)
os.chdir(folder)
subprocess.run([binaries + "/pm-scene", "synth", ROOT + "/tests/data/tiny.json", "--out", "bundle", "--quiet"], check=True)
with open("spec.json", "w") as file:
    json.dump({"schema": "physmas/run/1", "grid": {"n": 24}, "render": {"width": 32, "height": 32},
               "time": {"frames": 3, "substep_dt": 8e-4, "min_substep_dt": 2e-4, "max_substeps": 200},
               "screening": {"initial": 2, "rounds": 1, "tau": -9}}, file)
environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}


def start(run):
    return subprocess.Popen(
        ["make", "-f", ROOT + "/pipelines/installed.mk", "BIN=" + binaries, "run", "GAUSSIANS=bundle/gaussians.ply", "UP=z",
         "PROMPT=it falls", "SPEC=spec.json", "THREADS=1", "RUN=" + run],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)


def finish(run):
    process = start(run)
    output = process.communicate()[0].decode(errors="replace")
    return process.returncode, output


def tools_of(session):
    found = []
    for name in os.listdir("/proc"):
        if not name.isdigit():
            continue
        try:
            with open("/proc/%s/stat" % name) as file:
                fields = file.read().rsplit(")", 1)
            if int(fields[1].split()[3]) == session and fields[0].split("(", 1)[1].startswith("pm-"):
                found.append(int(name))
        except (OSError, IndexError):
            continue
    return found


def leftovers(run):
    return [os.path.join(d, n) for d, _, names in os.walk(run) for n in names if n.startswith(".") and ".tmp" in n]


begin = time.time()
status, output = finish("clean")
if status != 0:
    sys.exit("the undisturbed run failed:\n" + output)
span = time.time() - begin
wrong = []
for kill in range(1, kills + 1):
    process = start("storm")
    time.sleep(chance.uniform(0, span))
    targets = tools_of(process.pid) if kill % 3 == 0 else []
    try:
        if targets:
            os.kill(chance.choice(targets), signal.SIGKILL)
        else:
            os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass  # it had ended
    process.communicate()
    if kill % KILLS_PER_RERUN and kill != kills:
        continue
    status, output = finish("storm")
    compared = subprocess.run([sys.executable, "-B", ROOT + "/tests/tools/compare_runs.py", "clean", "storm"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    left = leftovers("storm")
    if status or compared.returncode or left:
        wrong.append("after %d kills: exit code %d\n%s%s%s" % (kill, status, output[-2000:] if status else "",
                                                                compared.stdout.decode(), "".join("left: %s\n" % f for f in left)))
        shutil.copytree("storm", "wrong-%d" % kill, symlinks=True)
    # The next storm meets a run that has parts, or none.
    for directory, _, names in os.walk("storm"):
        for name in names:
            if chance.random() < 0.5:
                os.remove(os.path.join(directory, name))
    if chance.random() < 0.3:
        shutil.rmtree("storm")
for text in wrong:
    print(text, file=sys.stderr)
print("kill storm\t%d kills, %d reruns\t%d\t%.0f" % (kills, (kills + KILLS_PER_RERUN - 1) // KILLS_PER_RERUN, len(wrong), time.time() - begin))
sys.exit(1 if wrong else 0)
