#!/usr/bin/env python3
"""Kills what makes a batch on a cluster, at random moments, and looks whether it ends with the bytes of one machine.

    cluster_storm.py BIN FOLDER [SCENES] [KILLS] [SEED]    prints a table; exit code 1 where anything is wrong

A Slurm of its own with four virtual nodes of two cores (tests/cluster/slurm.sh). First the scenes run by the executor local and by
slurm, which gives the overhead of a recipe. Then they run again while make (with all of its process group, or alone), an srun, a
slurm-job.sh, a node with its tasks, or slurmctld is killed; what was killed comes back after a few seconds, and make is
called again where it was killed.
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
binaries, folder = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
scenes = int(sys.argv[3]) if len(sys.argv) > 3 else 20
kills = int(sys.argv[4]) if len(sys.argv) > 4 else 50
chance = random.Random(int(sys.argv[5]) if len(sys.argv) > 5 else 1)
SLURM = [ROOT + "/tests/cluster/slurm.sh"]
NODES = ["n1", "n2", "n3", "n4"]

shutil.rmtree(folder, ignore_errors=True)
os.makedirs(folder)
os.chdir(folder)
for i in range(1, scenes + 1):
    subprocess.run([binaries + "/pm-scene", "synth", ROOT + "/tests/data/tiny.json", "--out", "s%d" % i, "--quiet"], check=True)
with open("list.txt", "w") as file:
    for i in range(1, scenes + 1):
        file.write('s%d/scene.json "PROMPT=the lollipop %s"\n' % (i, ("falls onto the floor", "is pushed to the left")[i % 2]))
with open("spec.json", "w") as file:
    file.write('{"schema": "physmas/run/1", "grid": {"n": 24}, "render": {"width": 64, "height": 64}, "time": {"frames": 6, "substep_dt": 8e-4,'
               ' "min_substep_dt": 2e-4, "max_substeps": 200}, "screening": {"initial": 2, "rounds": 2}}')
with open("resources", "w") as file:
    for stage in ("default", "bundle", "ground", "lift", "material", "simulate", "camera", "render", "best"):
        file.write(stage + ": 1 core, 300 MiB, 5 min\n")
environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
environment["SLURM_CONF"] = folder + "/slurm/slurm.conf"
os.environ["SLURM_CONF"] = environment["SLURM_CONF"]


def start(jobs, *words):
    return subprocess.Popen(["make", "--no-print-directory", "-f", ROOT + "/pipelines/installed.mk", "BIN=" + binaries, "THREADS=1", "-j%d" % jobs, "batch",
                             "SCENES=list.txt", "SPEC=spec.json", "BATCH=batch", *words],
                            env=environment, stdin=subprocess.DEVNULL, stdout=open("make.log", "a"), stderr=subprocess.STDOUT, start_new_session=True)


def timed(jobs, *words):
    begin = time.time()
    status = start(jobs, *words).wait()
    return status, time.time() - begin


def slurm(action, *words):
    subprocess.run(SLURM + [action, folder + "/slurm", *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def processes(text, inside=None):
    """Numbers of the processes with the text in their command line that have this Slurm; guards, which have another script's, are none of them."""
    found = []
    mark = ("SLURM_CONF=" + environment["SLURM_CONF"]).encode()
    for name in os.listdir("/proc"):
        if not name.isdigit():
            continue
        try:
            with open("/proc/%s/cmdline" % name, "rb") as file:
                line = file.read()
            with open("/proc/%s/environ" % name, "rb") as file:
                variables = file.read().split(b"\0")
        except OSError:
            continue
        if text.encode() in line and b"slurm-guard" not in line and mark in variables and (inside is None or any(v.startswith(inside) for v in variables)):
            found.append(int(name))
    return found


def jobs_left():
    queue = subprocess.run(["squeue", "--noheader"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout.decode().strip()
    return queue.splitlines() + ["process %d" % p for p in processes("pm-", b"SLURM_STEP_ID=")]


def compare():
    lines = subprocess.run([sys.executable, "-B", ROOT + "/tests/tools/compare_runs.py", "local", "batch"], stdout=subprocess.PIPE).stdout.decode().splitlines()
    return [line for line in lines if not line.endswith(("table.tsv", "log.txt", "batch.status")) and "/.live/" not in line and ": .live" not in line]


def recipes():
    count = 0
    for root, _, names in os.walk("batch"):
        if root.endswith("/.stamps"):
            count += sum(1 for n in names if n.endswith(".ran"))
    return count


wrong = []
rows = []


def row(what, tried, failed, seconds):
    rows.append("%s\t%s\t%d\t%.0f" % (what, tried, failed, seconds))


status, local_seconds = timed(1)
if status:
    sys.exit("the local batch failed: see %s/make.log" % folder)
os.rename("batch", "local")
slurm("start", "4", "2")
try:
    # One after the other, so that what is measured is the way and not the waiting.
    status, slurm_seconds = timed(1, "EXECUTOR=slurm", "RESOURCES=resources")
    different = compare()
    overhead = (slurm_seconds - local_seconds) / recipes()
    wrong += ["quiet: " + d for d in different] + (["quiet: exit code %d" % status] if status else [])
    row("%d scenes, %d recipes on nodes" % (scenes, recipes()), "local %.0f s, slurm %.0f s: %.3f s more for each" % (local_seconds, slurm_seconds, overhead),
        len(different), slurm_seconds)
    shutil.rmtree("batch")

    begin = time.time()
    done = {"make and its group": 0, "make": 0, "srun": 0, "slurm-job.sh": 0, "a node": 0, "slurmctld": 0}
    down = {}
    calls, whole, orphans = 0, 0, 0
    make = None
    while sum(done.values()) < kills:
        if make is None or make.poll() is not None:
            if make is not None and make.returncode == 0:
                # All was done: from the beginning, or in parts.
                whole += 1
                wrong += ["after %d kills: %s" % (sum(done.values()), d) for d in compare()]
                if chance.random() < 0.5:
                    shutil.rmtree("batch")
                else:
                    for root, _, names in os.walk("batch"):
                        for name in names:
                            if chance.random() < 0.3:
                                os.remove(os.path.join(root, name))
            make = start(6, "EXECUTOR=slurm", "RESOURCES=resources", "PATIENCE=10")
            calls += 1
        time.sleep(chance.uniform(0.3, 2.5))
        for daemon in [d for d, t in down.items() if time.time() > t]:
            slurm("revive", daemon)
            del down[daemon]
        what = chance.choice(list(done))
        if what == "make and its group":
            os.killpg(make.pid, signal.SIGKILL)
            make.wait()
        elif what == "make":
            os.kill(make.pid, signal.SIGKILL)
            make.wait()
        elif what in ("srun", "slurm-job.sh"):
            targets = processes(what)
            if not targets:
                continue
            try:
                os.kill(chance.choice(targets), signal.SIGKILL)
            except ProcessLookupError:
                continue
        else:
            daemon = "slurmctld" if what == "slurmctld" else chance.choice(NODES)
            if daemon in down:
                continue
            slurm("kill", daemon)
            down[daemon] = time.time() + chance.uniform(1, 6)
        done[what] += 1
        if make.poll() is not None and not down:
            # Nobody waits any more: within some seconds no job is left.
            for _ in range(100):
                left = jobs_left()
                if not left:
                    break
                time.sleep(0.2)
            orphans += len(left)
            wrong += ["after %d kills: left: %s" % (sum(done.values()), l) for l in left]
    for daemon in down:
        slurm("revive", daemon)
    make.wait()
    # Scenes that failed because somebody killed their wrapper are called again.
    for _ in range(3):
        make = start(6, "EXECUTOR=slurm", "RESOURCES=resources", "PATIENCE=10")
        make.wait()
        calls += 1
        different = compare()
        if not different:
            break
    for _ in range(100):
        left = jobs_left()
        if not left:
            break
        time.sleep(0.2)
    half = [os.path.join(d, n) for d, _, names in os.walk("batch") for n in names if ".tmp" in n or ".job" in n]
    wrong += ["at the end: " + d for d in different] + ["left: " + l for l in left + half]
    row("kills: " + ", ".join("%d %s" % (n, what) for what, n in done.items()), "%d kills, %d calls of make" % (kills, calls), len(wrong), time.time() - begin)
finally:
    slurm("stop")
print("attack\ttried\tfailed\tseconds")
print("\n".join(rows))
for text in wrong:
    print(text, file=sys.stderr)
sys.exit(1 if wrong or overhead > 0.3 else 0)
