#!/usr/bin/env python3
"""Lets every call of the system fail in turn, in every tool, on a tiny scene.

usage: walk.py BIN LIBRARY [--sample N] [--tools pm-lift,...] [--kinds write,...] [--seconds S] [--keep FOLDER]

A tool that meets the fault either ends well with the bytes that it has without the fault, or with exit code 3 and one line
"TOOL: error: ..."; no signal, no temporary file, no output with other bytes. Where a library uses memory that it did not get,
exit code 70 and a line that says so. --sample: at most N calls of each kind and tool
(first, last, and evenly between), else all of them; of memory and maps at most 200, because there are tens of thousands.
--seconds: of each run. Prints a line per tool and kind; exit code 1 where one of them did not hold.
"""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
ENOSPC, EIO, ENOMEM, EACCES = 28, 5, 12, 13

# Which calls fail how: (kind, errno, whether all later ones fail too).
FAULTS = [('open', EACCES, False), ('write', ENOSPC, False), ('write', ENOSPC, True), ('write', EIO, False), ('short', EIO, False),
          ('sync', EIO, False), ('rename', EIO, False), ('close', EIO, False), ('truncate', EIO, False),
          ('map', ENOMEM, False), ('memory', ENOMEM, False), ('thread', EIO, True)]
MANY = {'map', 'memory'}
MOST_OF_MANY = 100

CANDIDATES = ['support-stiff', 'soft']

# name: command, and what it writes (a folder stands for all that it holds). In a run's folder.
SCENE = '--scene bundle/scene.json'
STAGES = {
    'pm-scene synth': ('pm-scene synth tiny.json --out bundle', ['bundle']),
    'pm-scene import': ('pm-scene import bundle/gaussians.ply --prompt it\\ falls --run run.json --out imported', ['imported']),
    'pm-ground': (f'pm-ground {SCENE} --out .', ['inventory.json', 'plan.json', 'masks.h5']),
    'pm-lift': (f'pm-lift {SCENE} --inventory inventory.json --masks masks.h5 --out state.h5', ['state.h5']),
    'pm-material': (f'pm-material {SCENE} --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json',
                    ['evidence.json']),
    'pm-candidates': (f'pm-candidates {SCENE} --inventory inventory.json --plan plan.json --evidence evidence.json '
                      '--state state.h5 --out candidates', ['candidates']),
    **{f'pm-simulate {c}': (f'pm-simulate {SCENE} --state state.h5 --candidate candidates/{c}.json --out rollouts/{c}.h5',
                            [f'rollouts/{c}.h5', f'rollouts/{c}.json']) for c in CANDIDATES},
    **{f'pm-render {c}': (f'pm-render {SCENE} --state state.h5 --rollout rollouts/{c}.h5 --out videos/{c}.mp4',
                          [f'videos/{c}.mp4', f'videos/{c}.json']) for c in CANDIDATES},
    'pm-screen': (f'pm-screen {SCENE} --plan plan.json --evidence evidence.json --inventory inventory.json --candidates candidates '
                  '--rollouts rollouts --videos videos --round 0 --out screen/round0.json --accepted accepted.json '
                  '--final final.mp4', ['screen', 'accepted.json', 'final.mp4']),
    'pm-scene slice': (f'pm-scene slice {SCENE} --out spec', ['spec']),
    'pm-report': ('pm-report --run . --out report.html', ['report.html', 'report.json']),
    'pm-eval': (f'pm-eval motion {SCENE} --inventory inventory.json --state state.h5 --rollout rollouts/soft.h5 '
                '--reference rollouts/support-stiff.h5 --out metrics.json', ['metrics.json']),
}
# Walked for one candidate only, and not at all.
NOT_WALKED = {'pm-simulate soft', 'pm-render soft'}


def words(command, binaries):
    name, rest = command.split(' ', 1)
    return [str(binaries / name)] + [w.replace('\0', ' ') for w in rest.replace('\\ ', '\0').split(' ')] + ['--threads', '2']


def without_runtime(path):
    """Bytes of a file, without what differs from run to run."""
    data = path.read_bytes()
    if path.suffix == '.html':
        return re.sub(rb'<!--runtime-->.*?<!--/runtime-->|[0-9a-f]{16}(?=</code>)', b'', data, flags=re.S)
    if path.suffix != '.json':
        return data
    document = json.loads(data)
    document.pop('runtime', None)
    # Hashes of records that have such a part.
    text = re.sub(r'"sha256": "[0-9a-f]{64}"', '"sha256": ""', json.dumps(document))
    return text.encode()


def files_of(folder, outputs):
    found = {}
    for output in outputs:
        path = folder / output
        if path.is_dir():
            found.update({str(f.relative_to(folder)): f for f in path.rglob('*') if f.is_file()})
        elif path.exists():
            found[output] = path
    return found


def remove(folder, outputs):
    for output in outputs:
        path = folder / output
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def make_reference(folder, binaries):
    """The whole run without a fault; the names of what each stage wrote, with its bytes."""
    tiny = json.loads((ROOT / 'tests/data/tiny.json').read_text())
    tiny['spacing'] = 0.3
    tiny['run']['time']['frames'] = 3
    tiny['run']['render'] = {'width': 64, 'height': 64}
    folder.mkdir(parents=True)
    (folder / 'tiny.json').write_text(json.dumps(tiny))
    (folder / 'run.json').write_text(json.dumps({'schema': 'physmas/run/1', **{k: tiny['run'][k] for k in ('grid', 'time', 'render')}}))
    wanted = {}
    for stage, (command, outputs) in STAGES.items():
        done = subprocess.run(words(command, binaries), cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f'{stage} fails without a fault: {done.stderr}')
        if stage == 'pm-candidates':
            keep_candidates(folder)
        wanted[stage] = {name: without_runtime(path) for name, path in files_of(folder, outputs).items()}
    return wanted


def keep_candidates(folder):
    """The round has two candidates only, so that all of it can be executed."""
    path = folder / 'candidates/round0.json'
    document = json.loads(path.read_text())
    document['candidates'] = [c for c in document['candidates'] if c in CANDIDATES]
    path.write_text(json.dumps(document))


class Walk:
    def __init__(self, arguments, folder):
        self.arguments, self.folder = arguments, folder
        self.library = str(pathlib.Path(arguments.library).resolve())
        self.wanted = make_reference(folder / 'reference', arguments.binaries)

    def work_folder(self, worker, stage):
        """A copy of the run in which the stage has not been."""
        folder = self.folder / f'worker{worker}'
        if not folder.exists():
            shutil.copytree(self.folder / 'reference', folder)
        remove(folder, STAGES[stage][1])
        return folder

    def restore(self, folder, stage):
        """What the stage wrote, again as the run has it."""
        for output in STAGES[stage][1]:
            source, target = self.folder / 'reference' / output, folder / output
            remove(folder, [output])
            if source.is_dir():
                shutil.copytree(source, target)
            elif source.exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, target)

    def run(self, worker, stage, kind, at, error, stays, count=None):
        folder = self.work_folder(worker, stage)
        environment = {k: v for k, v in os.environ.items() if not k.startswith('PM_')}
        environment.update(LD_PRELOAD=self.library, PM_FAULT=kind, PM_FAULT_AT=str(at), PM_FAULT_ERROR=str(error),
                           PM_FAULT_STAYS='1' if stays else '', PM_FAULT_UNDER=str(folder), OMP_WAIT_POLICY='passive')
        if count:
            environment['PM_FAULT_COUNT'] = str(count)
        try:
            done = subprocess.run(words(STAGES[stage][0], self.arguments.binaries), cwd=folder, env=environment,
                                  capture_output=True, timeout=self.arguments.seconds)
            faults = self.judge(folder, stage, kind, done)
            ended = 'done' if done.returncode == 0 else 'refused'
        except subprocess.TimeoutExpired:
            faults, ended = [f'no end within {self.arguments.seconds} s'], 'hung'
        for left in [p for p in folder.rglob('.*.tmp*')]:
            left.unlink()
        self.restore(folder, stage)
        return ended, faults

    def judge(self, folder, stage, kind, done):
        faults = []
        tool = STAGES[stage][0].split(' ')[0]
        lines = done.stderr.decode(errors='replace').splitlines()
        wanted = self.wanted[stage]
        there = files_of(folder, STAGES[stage][1])
        if done.returncode == 0:
            faults += [f'exit 0 without {name}' for name in wanted if name not in there]
        elif done.returncode == 3 or (done.returncode == 70 and kind == 'memory' and 'memory ran out' in '\n'.join(lines)):
            errors = [line for line in lines if line.startswith(f'{tool}: error: ')]
            if len(errors) != 1:
                faults.append(f'{len(errors)} lines of error: {lines}')
        else:
            faults.append(f'exit code {done.returncode}: {lines}')
        faults += [f'a line of others: {line}' for line in lines
                   if line and not line.startswith(f'{tool}: ') and not line.startswith('libgomp: ')]
        for name, path in there.items():
            if '.tmp' in path.name:
                continue
            try:
                same = name in wanted and without_runtime(path) == wanted[name]
            except ValueError:
                same = False
            if stage == 'pm-candidates' and name == 'candidates/round0.json':
                same = True  # cut to two candidates in the reference
            if not same:
                faults.append(f'exit {done.returncode} and other bytes in {name}')
        faults += [f'left behind: {p.relative_to(folder)}' for p in folder.rglob('.*.tmp*')]
        return faults

    def chosen(self, kind, count):
        most = self.arguments.sample or (MOST_OF_MANY if kind in MANY else count)
        if count <= most:
            return list(range(1, count + 1))
        return sorted({1 + round(i * (count - 1) / (most - 1)) for i in range(most)} if most > 1 else {count})

    def walk(self, stages, kinds):
        bad = 0
        workers = max(1, self.arguments.jobs)
        pool = concurrent.futures.ThreadPoolExecutor(workers)
        free = collections.deque(range(workers))
        for stage in stages:
            counts = {}
            for kind in kinds:
                count_file = self.folder / 'count'
                count_file.unlink(missing_ok=True)
                _, faults = self.run(0, stage, kind, 0, EIO, False, count_file)
                if faults:
                    sys.exit(f'{stage} with the library and without a fault: {faults}')
                counts[kind] = int(count_file.read_text())

            def one(job):
                worker = free.popleft()
                try:
                    return job, self.run(worker, stage, *job)
                finally:
                    free.append(worker)

            for kind, error, stays in FAULTS:
                if kind not in kinds:
                    continue
                jobs = [(kind, at, error, stays) for at in self.chosen(kind, counts[kind])]
                ends = collections.Counter()
                for (_, at, _, _), (ended, faults) in pool.map(one, jobs):
                    ends[ended] += 1
                    for fault in faults:
                        bad += 1
                        print(f'{stage}: {kind} {at} of {counts[kind]}, errno {error}: {fault}', flush=True)
                print(f'{stage:26} {kind:9} errno {error:2}{" on" if stays else "   "} {len(jobs):5} of {counts[kind]:6} calls: '
                      f'{ends["done"]:4} done, {ends["refused"]:4} refused', flush=True)
        return bad


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('binaries', type=lambda p: pathlib.Path(p).resolve())
    parser.add_argument('library')
    parser.add_argument('--sample', type=int, default=0)
    parser.add_argument('--tools', default='')
    parser.add_argument('--kinds', default='')
    parser.add_argument('--seconds', type=float, default=120)
    parser.add_argument('--jobs', type=int, default=os.cpu_count())
    parser.add_argument('--keep', default='')
    arguments = parser.parse_args()
    stages = [s for s in STAGES if s not in NOT_WALKED]
    if arguments.tools:
        stages = [s for s in stages if s.split(' ')[0] in arguments.tools.split(',') or s in arguments.tools.split(',')]
    kinds = arguments.kinds.split(',') if arguments.kinds else sorted({kind for kind, _, _ in FAULTS})
    folder = pathlib.Path(arguments.keep or tempfile.mkdtemp(prefix='physmas-faults-'))
    try:
        bad = Walk(arguments, folder).walk(stages, kinds)
    finally:
        if not arguments.keep:
            shutil.rmtree(folder, ignore_errors=True)
    print('every fault ends in the right bytes or in a clear error' if bad == 0 else f'{bad} faults ended otherwise')
    return 1 if bad else 0


if __name__ == '__main__':
    sys.exit(main())
