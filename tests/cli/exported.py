#!/usr/bin/env python3
"""Compares files that pm-render wrote for other programs with the 3DGS PLY files of the same frames.

exported.py npz MOTION FOLDER | glb FILE PLY | usd MOTION FOLDER | usd-ply MOTION FRAME PLY | splats PLY COMPRESSED SPZ
The first two need plain Python alone.
"""
import glob
import json
import math
import os
import struct
import sys
import zipfile


def read_ply(path):
    """Rows as dictionaries."""
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    names = [line.split()[2].decode() for line in head.splitlines() if line.startswith(b"property")]
    return [dict(zip(names, row)) for row in struct.iter_unpack("<%df" % len(names), body)]


def frames_of(folder):
    return {int(os.path.basename(p)[6:10]): read_ply(p) for p in sorted(glob.glob(folder + "/frame_*.ply"))}


def near(a, b, tolerance, what):
    assert abs(a - b) <= tolerance, (what, a, b)


def unit(q):
    n = math.sqrt(sum(v * v for v in q))
    return [v / n for v in q]


def quaternion(row):
    return unit([row["rot_%d" % k] for k in range(4)])


def sigmoid(x):
    return 1 / (1 + math.exp(-x))


def read_npy(data):
    assert data[:8] == b"\x93NUMPY\x01\x00"
    size = struct.unpack("<H", data[8:10])[0]
    assert (10 + size) % 64 == 0
    head = eval(data[10:10 + size], {})
    kind = {"<f4": "f", "<f8": "d", "<i4": "i"}[head["descr"]]
    count = math.prod(head["shape"])
    values = struct.unpack("<%d%s" % (count, kind), data[10 + size:])
    return head["shape"], values


def check_npz(path, folder):
    frames = frames_of(folder)
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        arrays = {name[:-4]: read_npy(archive.read(name)) for name in archive.namelist()}
    shape, positions = arrays["positions"]
    T, N, _ = shape
    numbers, times = arrays["frames"][1], arrays["times"][1]
    assert arrays["rotations"][0] == (T, N, 4) and arrays["scales"][0] == (T, N, 3) and len(numbers) == len(times) == T
    assert len(arrays["rows"][1]) == N
    for k, number in enumerate(numbers):
        rows = frames[number]
        near(times[k], 0.04 * number, 1e-6, "time")
        assert len(rows) == N
        for i, row in enumerate(rows):
            for a, axis in enumerate("xyz"):
                near(positions[(k * N + i) * 3 + a], row[axis], 0, "position")
            # A selection of frames may number the axes otherwise.
            found = covariance(arrays["rotations"][1][(k * N + i) * 4:][:4], arrays["scales"][1][(k * N + i) * 3:][:3])
            expected = covariance(quaternion(row), [math.exp(row["scale_%d" % a]) for a in range(3)])
            for r in range(3):
                for c in range(3):
                    near(found[r][c], expected[r][c], 1e-6, "covariance")
            near(arrays["opacities"][1][i], sigmoid(row["opacity"]), 1e-6, "opacity")


def check_glb(path, ply):
    rows = read_ply(ply)
    with open(path, "rb") as file:
        data = file.read()
    magic, version, size, length = struct.unpack("<4sIII", data[:16])
    assert magic == b"glTF" and version == 2 and size == len(data) and data[16:20] == b"JSON" and length % 4 == 0
    document, binary = json.loads(data[20:20 + length]), data[20 + length + 8:]
    assert data[20 + length + 4:20 + length + 8] == b"BIN\0" and document["buffers"][0]["byteLength"] == len(binary)
    assert document["extensionsUsed"] == ["KHR_gaussian_splatting"]
    primitive = document["meshes"][0]["primitives"][0]
    assert primitive["mode"] == 0
    assert primitive["extensions"]["KHR_gaussian_splatting"]["kernel"] == "ellipse"

    def values(name):
        accessor = document["accessors"][primitive["attributes"][name]]
        view = document["bufferViews"][accessor["bufferView"]]
        assert accessor["count"] == len(rows)
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        kind = {5126: "f", 5121: "B"}[accessor["componentType"]]
        flat = struct.unpack("<%d%s" % (width * len(rows), kind), binary[view["byteOffset"]:][:view["byteLength"]])
        return [flat[width * i:width * (i + 1)] for i in range(len(rows))]

    positions, rotations = values("POSITION"), values("KHR_gaussian_splatting:ROTATION")
    scales, opacities = values("KHR_gaussian_splatting:SCALE"), values("KHR_gaussian_splatting:OPACITY")
    harmonics, colors = values("KHR_gaussian_splatting:SH_DEGREE_0_COEF_0"), values("COLOR_0")
    for i, row in enumerate(rows):
        # z was up: (x, y, z) -> (x, z, -y).
        for a, b in zip(positions[i], (row["x"], row["z"], -row["y"])):
            near(a, b, 1e-6, "position")
        found = rotations[i]
        near(sum(v * v for v in found), 1, 1e-5, "length of the rotation")
        for a, b in zip(sorted(scales[i]), sorted(math.exp(row["scale_%d" % k]) for k in range(3))):
            near(a, b, 1e-6, "scale")
        near(opacities[i][0], sigmoid(row["opacity"]), 1e-6, "opacity")
        for c in range(3):
            near(harmonics[i][c], row["f_dc_%d" % c], 0, "harmonic")
            level = 255 * min(1, max(0, 0.5 + 0.28209479 * row["f_dc_%d" % c]))
            near(colors[i][c], level, 0.51, "colour")
        # Covariances say what rotations and scales mean together.
        turn = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
        S = covariance(quaternion(row), [math.exp(row["scale_%d" % k]) for k in range(3)])
        expected = product(product(turn, S), [list(r) for r in zip(*turn)])
        got = covariance([found[3], *found[:3]], scales[i])
        for r in range(3):
            for c in range(3):
                near(got[r][c], expected[r][c], 1e-6, "covariance")


def product(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(3)) for c in range(3)] for r in range(3)]


def covariance(q, s):
    w, x, y, z = q
    R = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    M = [[R[r][k] * s[k] for k in range(3)] for r in range(3)]
    return product(M, [list(r) for r in zip(*M)])


def check_usd(path, folder):
    from pxr import Usd, UsdGeom, UsdVol
    frames = frames_of(folder)
    stage = Usd.Stage.Open(path)
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 25
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (min(frames), max(frames))
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    prim = stage.GetDefaultPrim().GetChild("Splats")
    splats = UsdVol.ParticleField3DGaussianSplat(prim)
    assert splats and prim.GetTypeName() == "ParticleField3DGaussianSplat"
    get = lambda name, frame: prim.GetAttribute(name).Get(frame)
    # Half precision keeps 11 bits.
    half = 2.0 ** -11
    previous = None
    for frame, rows in frames.items():
        positions, scales, turns = get("positions", frame), get("scales", frame), get("orientationsh", frame)
        opacities = get("opacities", frame)
        harmonics = get("radiance:sphericalHarmonicsCoefficientsh", frame)
        count = (get("radiance:sphericalHarmonicsDegree", frame) + 1) ** 2
        assert len(positions) == len(scales) == len(turns) == len(opacities) == len(rows)
        assert len(harmonics) == count * len(rows)
        low, high = get("extent", frame)
        quaternions = [[q.GetReal(), *q.GetImaginary()] for q in turns]
        for i, row in enumerate(rows):
            for a, axis in enumerate("xyz"):
                near(positions[i][a], row[axis], 0, "position")
                near(scales[i][a], math.exp(row["scale_%d" % a]), 1e-6, "scale")
                assert low[a] < positions[i][a] < high[a]
            for a, b in zip(quaternions[i], quaternion(row)):
                near(a, b, half, "orientation")
            near(opacities[i], sigmoid(row["opacity"]), 1e-6, "opacity")
            for c in range(3):
                near(harmonics[count * i][c], row["f_dc_%d" % c], half * (1 + abs(row["f_dc_%d" % c])), "harmonic")
                rest = count - 1
                for k in range(rest):
                    value = row["f_rest_%d" % (c * rest + k)]
                    near(harmonics[count * i + 1 + k][c], value, half * (1 + abs(value)), "harmonic")
        if previous:
            assert all(sum(a * b for a, b in zip(p, q)) > 0 for p, q in zip(previous, quaternions)), "a flip"
        previous = quaternions
    # What stays the same is written once.
    assert prim.GetAttribute("opacities").GetNumTimeSamples() == 0
    from pxr import UsdValidation
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    errors = [error.GetMessage() for error in context.Validate(stage)]
    assert not errors, errors


def usd_frame_as_ply(path, frame, out):
    """What a program that knows the schema sees of one frame."""
    from pxr import Usd
    stage = Usd.Stage.Open(path)  # prims live as long as it does
    prim = stage.GetDefaultPrim().GetChild("Splats")
    get = lambda name: prim.GetAttribute(name).Get(float(frame))
    assert get("radiance:sphericalHarmonicsDegree") == 0
    names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
    columns = zip(get("positions"), get("radiance:sphericalHarmonicsCoefficientsh"), get("opacities"), get("scales"),
                  get("orientationsh"))
    rows = [[*p, *c, math.log(max(1e-6, o) / max(1e-6, 1 - o)), *map(math.log, s), q.GetReal(), *q.GetImaginary()]
            for p, c, o, s, q in columns]
    head = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(rows)
    head += "".join("property float %s\n" % name for name in names) + "end_header\n"
    with open(out, "wb") as file:
        file.write(head.encode() + b"".join(struct.pack("<14f", *row) for row in rows))


def check_splats(plain, compressed, spz):
    import gsply
    import numpy as np
    from plyfile import PlyData
    for path in sorted(glob.glob(plain + "/frame_*.ply"))[::4]:
        number = os.path.basename(path)[:10]
        vertex = PlyData.read(path)["vertex"]
        assert [tuple(row) for row in vertex.data] == [tuple(row.values()) for row in read_ply(path)]
        position = np.stack([vertex[axis] for axis in "xyz"], 1)
        size = np.ptp(position, axis=0).max()
        packed = gsply.plyread(f"{compressed}/{number}.compressed.ply")
        # Sorted along each axis, as the Gaussians come in another order.
        assert np.abs(np.sort(packed.means, 0) - np.sort(position, 0)).max() < size / 500
        tiny = gsply.read_spz(f"{spz}/{number}.spz")
        # z was up.
        turned = position[:, [0, 2, 1]] * [1, 1, -1]
        assert np.abs(tiny.means - turned).max() < 1e-4, np.abs(tiny.means - turned).max()
        scale = np.sort(np.stack([vertex[f"scale_{k}"] for k in range(3)], 1), 1)
        assert np.abs(np.sort(tiny.scales, 1) - np.maximum(scale, -10)).max() < 1 / 16


if __name__ == "__main__":
    {"npz": check_npz, "glb": check_glb, "usd": check_usd, "usd-ply": usd_frame_as_ply, "splats": check_splats}[sys.argv[1]](*sys.argv[2:])
