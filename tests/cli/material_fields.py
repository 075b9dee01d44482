#!/usr/bin/env python3
"""Material fields of a bundle's Gaussians as other programs write them, in plain Python.

material_fields.py write PLY FILE.npz|FILE.usda [HOW]   one sample per Gaussian. HOW: halves (default; by height), constant,
                                                        moved (elsewhere), or a bad kind (BAD below)
material_fields.py same A.npz B.npz MOST                fails when two motions (pm-render --npz) differ by more
material_fields.py differ A.npz B.npz LEAST             fails when they differ by less
"""
import math
import struct
import sys
import zipfile

import exported

ORDER = ("positions", "youngs_modulus", "poisson_ratio", "density")
SPLIT = 0.65  # height in the scene that parts the halves
HALVES = ((4e4, 0.42, 600.0), (2e5, 0.42, 1100.0))  # below, above


def npy(values, shape, kind="f"):
    text = "{'descr': '<%s', 'fortran_order': False, 'shape': %r, }" % ({"f": "f4", "d": "f8"}[kind], shape)
    text = text.ljust((len(text) + 74) // 64 * 64 - 11) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + struct.pack("<%d%s" % (len(values), kind), *values)


def field(points, how):
    numbers = [HALVES[p[2] > SPLIT] if how != "constant" else HALVES[0] for p in points]
    if how == "moved":
        points = [(x + 100, y, z) for x, y, z in points]
    n = len(points)
    arrays = {"positions": ([c for p in points for c in p], (n, 3))}
    for k, name in enumerate(ORDER[1:]):
        arrays[name] = ([m[k] for m in numbers], (n,))
    return arrays


def cut(arrays, name):
    arrays[name] = (arrays[name][0][:-1], (len(arrays[name][0]) - 1,))


def put(arrays, name, value):
    arrays[name][0][3] = value


BAD = {
    "missing": lambda a: a.pop("density"),
    "shape": lambda a: cut(a, "poisson_ratio"),
    "nan": lambda a: put(a, "youngs_modulus", math.nan),
    "negative": lambda a: put(a, "density", -1.0),
    "nu": lambda a: put(a, "poisson_ratio", 0.7),
    "nowhere": lambda a: put(a, "positions", math.inf),
    "huge": lambda a: a.__setitem__("density", ([1.0], (1 << 60,))),
}


def write(ply, path, how="halves"):
    arrays = field([(row["x"], row["y"], row["z"]) for row in exported.read_ply(ply)], how)
    if how in BAD:
        BAD[how](arrays)
    if path.endswith(".usda"):
        text = lambda values: "[" + ", ".join(repr(struct.unpack("<f", struct.pack("<f", v))[0]) for v in values) + "]"
        flat = arrays["positions"][0]
        points = ", ".join("(%r, %r, %r)" % tuple(flat[i:i + 3]) for i in range(0, len(flat), 3))
        with open(path, "w") as out:
            out.write('#usda 1.0\n\ndef Points "voxels"\n{\n    point3f[] points = [%s]\n' % points)
            for name, usd in zip(ORDER[1:], ("yms", "prs", "rhos")):
                if name in arrays:
                    out.write("    float[] primvars:%s = %s (\n        interpolation = \"vertex\"\n    )\n" % (usd, text(arrays[name][0])))
            out.write("}\n")
        return
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, (values, shape) in arrays.items():
            archive.writestr(zipfile.ZipInfo(name + ".npy"), npy(values, shape))


def motion(path):
    shape, values = exported.read_npy(zipfile.ZipFile(path).read("positions.npy"))
    return values, shape


def difference(a, b):
    (p, p_shape), (q, q_shape) = motion(a), motion(b)
    assert p_shape == q_shape, (p_shape, q_shape)
    moved = max(abs(x - y) for x, y in zip(p[:3 * p_shape[1]], p[-3 * p_shape[1]:]))
    assert moved > 0.01, "nothing moves"
    return max(abs(x - y) for x, y in zip(p, q))


if __name__ == "__main__":
    what, *arguments = sys.argv[1:]
    if what == "write":
        write(*arguments)
    elif what == "same":
        found = difference(*arguments[:2])
        assert found <= float(arguments[2]), found
        print(found)
    elif what == "differ":
        found = difference(*arguments[:2])
        assert found >= float(arguments[2]), found
        print(found)
    else:
        sys.exit(__doc__)
