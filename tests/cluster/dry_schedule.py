#!/usr/bin/env python3
"""A batch on a cluster without the cluster: when its jobs would start and end, from measured durations.

    dry_schedule.py [--scenes 10000] [--nodes 100] [--scale 1] ...    prints a row per way of doing it

It follows pipelines/batch.mk: all scenes learn one fact with each restart of make, and a restart waits for the slowest of them; a job is
ready when those before it in its scene have ended; make starts ready jobs in the order of scenes, at most -j at a time. Beside
the nodes' cores three things can be the limit: make's own time (a restart reads the rules of every scene that is not done), the
processors of the machine where make runs (each job takes some of their time), and the jobs that Slurm starts in a second.
The cores of all nodes are one pool: how jobs fit onto single nodes is not looked at.
"""
import argparse
import heapq
import random

parser = argparse.ArgumentParser()
parser.add_argument("--scenes", type=int, default=10000)
parser.add_argument("--nodes", type=int, default=100)
parser.add_argument("--cores", type=int, default=32, help="of a node")
parser.add_argument("--scale", type=float, default=1, help="how much longer stages take than those of the example cake")
parser.add_argument("--spread", type=float, default=0.5, help="the deviation of the logarithm of a scene's size")
parser.add_argument("--repairs", type=float, default=0.3, help="the share of scenes that go on to a next round of three candidates")
parser.add_argument("--first-reading", type=float, default=0.030, help="seconds of make for a scene, when it reads its rules first")
parser.add_argument("--reading", type=float, default=0.004, help="and each further time")
parser.add_argument("--job-cost", type=float, default=0.08, help="processor seconds of a job where make runs")
parser.add_argument("--submit-cores", type=int, default=8, help="of the machine where make runs")
parser.add_argument("--rate", type=float, default=10, help="jobs that Slurm starts in a second")
parser.add_argument("--slots", type=int, default=1000, help="make -j, of all makes together")
options = parser.parse_args()

# Stage: processor seconds of the example cake, cores, and whether it stays where make runs (docs/cluster.md).
STAGES = {
    "bundle": (0.43, 2, False), "spec": (0.08, 1, True), "ground": (2.2, 2, False), "lift": (0.39, 4, False), "material": (0.14, 2, False),
    "candidates": (0.03, 1, True), "simulate": (4.4, 8, False), "camera": (1.4, 2, False), "render": (1.9, 4, False), "screen": (0.28, 1, True),
}
START = [("bundle", 1), ("spec", 1), ("ground", 1), ("lift", 1), ("material", 1), ("candidates", 1)]


def restarts_of(rounds):
    """What a scene does between two restarts: stages one after the other, each so many times beside each other."""
    parts = [START]
    for number in range(rounds):
        count = 6 if number == 0 else 3
        parts.append([("simulate", count), ("camera", 1), ("render", count), ("screen", 1)])
        if number + 1 < rounds:
            parts.append([("candidates", 1)])
    return parts


class Rate:
    """Something that begins so many things in a second."""

    def __init__(self, per_second):
        self.gap, self.next = 1 / per_second, 0.0

    def after(self, now):
        self.next = max(self.next, now) + self.gap
        return self.next


def run(way, makes):
    chance = random.Random(1)
    sizes = [options.scale * chance.lognormvariate(0, options.spread) for _ in range(options.scenes)]
    plans = [restarts_of(1 + (chance.random() < options.repairs) * (1 + (chance.random() < options.repairs))) for _ in range(options.scenes)]
    submit = Rate(options.submit_cores / options.job_cost)
    # Steps are begun by the nodes, workers begin their jobs themselves.
    slurm = Rate({"jobs": options.rate, "steps": 10 * options.rate, "array": 1e6}[way])
    free, used, own_time, jobs, waits = options.nodes * options.cores, 0.0, 0.0, 0, 0.0
    slots = [max(1, options.slots // makes)] * makes
    part = [0] * makes
    open_scenes = [0] * makes
    alive = [list(range(m, options.scenes, makes)) for m in range(makes)]
    place, beside = [0] * options.scenes, [0] * options.scenes
    events, ready, count = [], [[] for _ in range(makes)], 0

    def push(when, what):
        nonlocal count
        count += 1
        heapq.heappush(events, (when, count, what))

    def restart(m, now):
        nonlocal own_time
        reading = len(alive[m]) * (options.first_reading if part[m] == 0 else options.reading)
        own_time += reading
        open_scenes[m] = len(alive[m])
        push(now + reading, ("read", m))

    def offer(scene, m):
        """The scene's next stage, or its end for this part."""
        chain = plans[scene][part[m]]
        if place[scene] == len(chain):
            open_scenes[m] -= 1
            return
        stage, number = chain[place[scene]]
        beside[scene] = number
        for _ in range(number):
            heapq.heappush(ready[m], (scene, place[scene], stage))

    for m in range(makes):
        restart(m, 0.0)
    now = last = 0.0
    while events:
        now, _, what = heapq.heappop(events)
        waits += free * (now - last)
        last = now
        if what[0] == "read":
            for scene in alive[what[1]]:
                place[scene] = 0
                offer(scene, what[1])
        else:
            _, m, scene, cores = what
            slots[m] += 1
            free += cores
            beside[scene] -= 1
            if beside[scene] == 0:
                place[scene] += 1
                offer(scene, m)
            if open_scenes[m] == 0:
                part[m] += 1
                alive[m] = [s for s in alive[m] if len(plans[s]) > part[m]]
                if alive[m]:
                    restart(m, now)
        for m in range(makes):
            # A job that has its slot waits in Slurm for its cores; those behind it wait with it.
            while ready[m] and slots[m]:
                stage = ready[m][0][2]
                seconds, cores, stays = STAGES[stage]
                if not stays and cores > free:
                    break
                scene = heapq.heappop(ready[m])[0]
                begin = submit.after(now)
                if not stays:
                    begin = max(begin, slurm.after(now))
                    free -= cores
                    used += seconds * sizes[scene]
                    jobs += 1
                slots[m] -= 1
                push(begin + seconds * sizes[scene] / cores, ("end", m, scene, 0 if stays else cores))
    return now, used / (now * options.nodes * options.cores), jobs, own_time / makes


print("way\tmakes\thours\tcores at work\tjobs on nodes\tof them a second\tmake's own minutes")
for way in ("jobs", "steps", "array"):
    for makes in (1, 8):
        span, used, jobs, own = run(way, makes)
        print("%s\t%d\t%.2f\t%.0f %%\t%d\t%.1f\t%.1f" % (way, makes, span / 3600, 100 * used, jobs, jobs / span, own / 60))
