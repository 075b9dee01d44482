#!/usr/bin/env python3
"""Checks the direction of every include, and that tests/unit mirrors lib.

    tests/check-includes.py [ROOT]

Prints one line per violation, FILE:LINE: what is wrong and what is allowed, and exits with 1 when there is one.
"""
import os
import re
import sys

# Rooms of lib/ in the order of the arrows. A room includes itself and every room of an earlier line; rooms of one line
# do not include each other.
LEVELS = [
    ["base"],
    ["records"],
    ["scene"],
    ["bundle", "splat", "remote"],
    ["plan", "masks", "lift", "material", "candidate", "screen", "metrics", "tables"],  # the stages
    ["bind"],
    ["studies", "report"],
    ["tools"],
]

# (room, included room): why, although they stand in one line.
SIDEWAYS = {
    ("bundle", "splat"): "the views of a scene are rendered",
    ("tables", "metrics"): "they are tables of measures",
}

# The solver knows base/ alone, and only these know the solver.
SOLVER = "mpm"
SOLVER_INCLUDES = ["base"]
INCLUDE_SOLVER = ["bind", "studies", "tools"]
# Its algebra knows nothing of the solver. (room, folder that it includes): why.
INCLUDE_ALGEBRA = {
    ("splat", "mpm/math"): "the polar rotation is defined once",
}

# Folders inside the solver: what each includes besides itself and SOLVER_INCLUDES, "domain.h" being lib/mpm/domain.h.
SOLVER_FOLDERS = {
    "math": [],
    "material": ["math"],
    "action": ["math", "domain.h", "state.h"],
    "rigid": ["math", "material", "action", "body_contact.h", "domain.h", "state.h", "timestep.h", "stepper.h"],
    "cpu": ["math", "material", "action", "rigid", "body_contact.h", "domain.h", "state.h", "energy_budget.h", "stepper.h", "stepper_setup.h"],
    "statics": ["math", "material", "action", "domain.h", "state.h"],
}
# Sums over whole states are left to the CPU.
SOLVER_FOLDERS["cuda"] = SOLVER_FOLDERS["cpu"] + ["cpu"]

# Rooms with nothing that a unit test could call: why.
WITHOUT_UNIT_TESTS = {}

INCLUDE = re.compile(r'\s*#\s*include\s*"([^"]+)"')
SOURCES = (".h", ".cpp", ".cu")


def allowed_rooms(room):
    """Rooms that `room` may include besides itself."""
    if room == SOLVER:
        return list(SOLVER_INCLUDES)
    allowed = []
    for level in LEVELS:
        if room in level:
            break
        allowed += level
    else:
        return None
    allowed += [to for frm, to in SIDEWAYS if frm == room]
    return allowed + ([SOLVER] if room in INCLUDE_SOLVER else [])


def complaint(path, included):
    """What is wrong with `included`, a path below lib/, in the file `path` (lib/... or tools/...); None: nothing."""
    parts = path.split("/")
    room = "tools" if parts[0] == "tools" else parts[1]
    to = included.split("/")
    if len(to) == 1 or to[0] in (".", ".."):
        return "expected a path from lib/, such as \"%s/%s\"" % (room, to[-1])
    allowed = allowed_rooms(room)
    if allowed is None:
        return "lib/%s has no place in the order of rooms (tests/check-includes.py)" % room
    if (room, "/".join(to[:2])) in INCLUDE_ALGEBRA:
        return None
    if to[0] != room and to[0] not in allowed:
        return "%s/ includes %s only" % (room, ", ".join(sorted(allowed + [room])))
    if room == to[0] == SOLVER and len(parts) > 3:  # a file in a folder of the solver
        folder = parts[2]
        inside = SOLVER_FOLDERS.get(folder)
        if inside is None:
            return "lib/mpm/%s has no place in the order of the solver's folders (tests/check-includes.py)" % folder
        if to[1] != folder and to[1] not in inside:
            return "mpm/%s/ includes %s only" % (folder, ", ".join(SOLVER_INCLUDES + ["mpm/" + f for f in [folder] + inside]))
    return None


def sources_below(root, folder):
    for at, folders, files in os.walk(os.path.join(root, folder)):
        folders.sort()
        for name in sorted(files):
            if name.endswith(SOURCES):
                yield os.path.relpath(os.path.join(at, name), root).replace(os.sep, "/")


def check_includes(root):
    found = []
    for path in list(sources_below(root, "lib")) + list(sources_below(root, "tools")):
        if path.count("/") < 2 and path.startswith("lib/"):
            found.append("%s:1: expected in a room of lib/" % path)
            continue
        with open(os.path.join(root, path), encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                match = INCLUDE.match(line)
                wrong = match and complaint(path, match.group(1))
                if wrong:
                    found.append('%s:%d: found #include "%s"; %s' % (path, number, match.group(1), wrong))
    return found


def folders_with_sources(root, top):
    return {os.path.dirname(path)[len(top) + 1:] for path in sources_below(root, top)
            if path.endswith((".cpp", ".cu")) and os.path.dirname(path) != top}


def check_mirror(root):
    """tests/unit has the rooms and folders of lib, and every room of lib that has code has tests."""
    found = []
    tested = folders_with_sources(root, "tests/unit")
    for folder in sorted(tested):
        if not os.path.isdir(os.path.join(root, "lib", folder)):
            found.append("tests/unit/%s:1: lib/%s does not exist; expected the folders of lib/" % (folder, folder))
    tested_rooms = {folder.split("/")[0] for folder in tested}
    for room in sorted({folder.split("/")[0] for folder in folders_with_sources(root, "lib")} - tested_rooms):
        if room not in WITHOUT_UNIT_TESTS:
            found.append("lib/%s:1: expected unit tests in tests/unit/%s" % (room, room))
    return found


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    found = check_includes(root) + check_mirror(root)
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
