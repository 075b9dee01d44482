#!/usr/bin/env python3
"""Compares two folders of runs: every file, JSON records and pages without their `runtime`, without what make notes in .stamps.

    compare_runs.py A B    prints what differs; exit code 1 where anything does
"""
import json
import os
import re
import sys


def files_of(folder):
    found = {}
    for root, folders, names in os.walk(folder):
        folders[:] = [f for f in folders if f != ".stamps"]
        for name in names:
            path = os.path.join(root, name)
            found[os.path.relpath(path, folder)] = path
    return found


def content(path):
    if os.path.islink(path):
        return os.readlink(path)
    with open(path, "rb") as file:
        data = file.read()
    if path.endswith(".json"):
        document = json.loads(data)
        document.pop("runtime", None)
        return document
    if path.endswith(".html"):
        return re.sub(rb"<!--runtime-->.*?<!--/runtime-->", b"", data, flags=re.S)
    return data


a, b = files_of(sys.argv[1]), files_of(sys.argv[2])
different = ["only in %s: %s" % (sys.argv[1 if name in a else 2], name) for name in sorted(set(a) ^ set(b))]
different += ["different: " + name for name in sorted(set(a) & set(b)) if content(a[name]) != content(b[name])]
print("\n".join(different), end="\n" if different else "")
sys.exit(1 if different else 0)
