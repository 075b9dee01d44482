#!/usr/bin/env python3
"""Files after public reports about other tools (../shared/cases, which is no part of the project), each imported and held
against what it holds, as plain Python reads it, or against the figure that several of them show.

reported_cases.py TOOL CASES FOLDER KIND     KIND: gaussians, cameras, configurations. Prints what differs.
"""
import json
import math
import os
import re
import struct
import subprocess
import sys

import exported
import foreign_files

LENSES = "fx fy cx cy width height".split()
C0 = 0.28209479177387814
TYPES = {"float": "f", "float32": "f", "double": "d", "float64": "d", "uchar": "B", "uint8": "B", "char": "b", "short": "h",
         "ushort": "H", "int": "i", "int32": "i", "uint": "I", "uint32": "I"}


def rows_of(path):
    """The vertices of any PLY, as dictionaries of what the file says."""
    with open(path, "rb") as file:
        head, body = re.split(rb"end_header\r?\n", file.read(), maxsplit=1)
    elements, order = [], "<"
    for line in head.decode("latin1").split("\n"):
        words = line.split()
        if words[:1] == ["format"]:
            order = ">" if words[1] == "binary_big_endian" else "<"
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        if words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    at = 0

    def take(kind):
        nonlocal at
        (value,) = struct.unpack_from(order + TYPES[kind], body, at)
        at += struct.calcsize(TYPES[kind])
        return value

    for name, count, properties in elements:
        rows = []
        for _ in range(count):
            row = {}
            for p in properties:
                row[p[-1]] = [take(p[2]) for _ in range(take(p[1]))] if p[0] == "list" else take(p[0])
            rows.append(row)
        if name == "vertex":
            return rows
    raise AssertionError("no vertices in " + path)


def single(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


class Cases:
    def __init__(self, tool, cases, folder):
        self.tool, self.cases, self.folder, self.wrong = tool, cases, folder, []
        self.plain = rows_of(self.at("right/plain.ply"))

    def at(self, name):
        return os.path.join(self.cases, name)

    def say(self, name, what):
        self.wrong.append("%s: %s" % (name, what))

    def run(self, name, *arguments, out=None):
        """The bundle's folder, exit code and what was said."""
        out = out or os.path.join(self.folder, re.sub(r"\W+", "-", name + " ".join(arguments))[-120:])
        done = subprocess.run([self.tool, "import", "--prompt", "it falls", "--out", out, *arguments], capture_output=True, text=True)
        return out, done.returncode, done.stderr + done.stdout

    def refused(self, name, text, *arguments):
        out, status, said = self.run(name, *(arguments or [self.at(name)]))
        if status != 3 or text not in said or len(said.strip().split("\n")) != 1:
            self.say(name, "exit code %d, said %r, expected %r" % (status, said, text))
        if os.path.exists(out):
            self.say(name, "left something behind")

    def bundle(self, name, said_text, *arguments):
        out, status, said = self.run(name, *arguments, self.at(name))
        if status != 0:
            self.say(name, "exit code %d: %s" % (status, said))
            return None
        if said_text not in said or (not said_text and said):
            self.say(name, "said %r, expected %r" % (said, said_text))
        return out

    def compare(self, name, got, expected, tolerances):
        if len(got) != len(expected):
            return self.say(name, "%d Gaussians, expected %d" % (len(got), len(expected)))
        for i, (a, b) in enumerate(zip(got, expected)):
            for key, value in b.items():
                limit = next((t for start, t in tolerances.items() if key.startswith(start)), 0)
                if key not in a or not abs(a[key] - value) <= limit:
                    return self.say(name, "Gaussian %d has %s %r, expected %r" % (i, key, a.get(key), value))

    def holds(self, name, expected, said="", up="-y", tolerances=None, decibels=None, arguments=()):
        """expected: rows; what they do not name does not matter. decibels: of the front view against the plain figure's."""
        out = self.bundle(name, said, *arguments)
        if out is None:
            return
        got = exported.read_ply(out + "/gaussians.ply")
        self.compare(name, got, expected, tolerances or {})
        options = json.load(open(out + "/scene.json"))["provenance"]["options"]
        if options["up"] != up:
            self.say(name, "up is %s, expected %s" % (options["up"], up))
        if decibels:
            if not hasattr(self, "picture"):
                self.picture = self.run("right/plain.ply", self.at("right/plain.ply"), out=os.path.join(self.folder, "plain-picture"))[0]
            found = foreign_files.psnr(self.picture + "/views/front.png", out + "/views/front.png")
            if found < decibels:
                self.say(name, "its picture is %.1f dB off, expected %g" % (found, decibels))

    # What the bundle holds of a row of a 3DGS PLY.
    def row(self, row):
        kept = {k: single(row[k]) for k in ("x", "y", "z", "opacity", *("scale_%d" % k for k in range(3)), *("f_dc_%d" % k for k in range(3)))
                if k in row}
        rest = sum(k.startswith("f_rest_") for k in row) // 3
        for channel in range(3):
            for k in range(min(rest, 15)):
                kept["f_rest_%d" % (channel * min(rest, 15) + k)] = single(row["f_rest_%d" % (channel * rest + k)])
        return kept

    def gaussians(self):
        as_they_stand = {name: "" for name in (
            "all_double big_endian camera_element_first crlf flat float32_names list_after millimetres ml_sharp one_huge plain rest_24 rest_9 "
            "tiny z_up vase").split()}
        for name in as_they_stand:
            path = "right/%s.ply" % name
            self.holds(path, [self.row(r) for r in rows_of(self.at(path))], decibels=100 if name in ("big_endian", "crlf", "list_after") else None)
        for path, said, up in (("right/brush_4d.ply", "is not followed", "-y"), ("right/sky_half_percent.ply", "--crop -0.6", "-y"),
                               ("wrong/antialiased_comment.ply", "opacities are compensated", "-y"), ("wrong/brush_y.ply", "is not followed", "-y"),
                               ("wrong/extra_tail.ply", "21 bytes after the last row", "-y"), ("wrong/nerfstudio_z.ply", "z is taken as up", "z"),
                               ("wrong/faint.ply", "--opacity-threshold", "-y"), ("wrong/one.ply", "one Gaussian only", "-y"),
                               ("wrong/linear_scale.ply", "--read linear-scales", "-y"), ("wrong/rest_72.ply", "degree 4 are left out", "-y"),
                               ("wrong/sky3.ply", "--crop auto takes it alone", "-y"), ("wrong/skybox.ply", "--crop auto takes it alone", "-y")):
            self.holds(path, [self.row(r) for r in rows_of(self.at(path))], said, up)
        figure = [self.row(r) for r in self.plain]

        # Not as they stand.
        for path in ("wrong/sky3.ply", "wrong/skybox.ply"):
            self.holds(path, figure, "--crop auto takes 384", decibels=100, arguments=("--crop", "auto"))
        logarithms = [dict(self.row(r), **{"scale_%d" % k: math.log(r["scale_%d" % k]) for k in range(3)}) for r in rows_of(self.at("wrong/linear_scale.ply"))]
        self.holds("wrong/linear_scale.ply", logarithms, "", tolerances={"scale": 1e-6}, arguments=("--read", "linear-scales"))
        self.holds("wrong/nan_few.ply", [self.row(r) for r in rows_of(self.at("wrong/nan_few.ply")) if all(math.isfinite(v) for v in r.values())],
                   "3 of 384 Gaussians were dropped")
        offset = {"x": 431000, "y": 5412000, "z": 213}
        moved = [{**r, **{k: r[k] - offset[k] for k in offset}} for r in rows_of(self.at("wrong/utm_double.ply"))]
        self.holds("wrong/utm_double.ply", [self.row(r) for r in moved], "(431000, 5412000, 213) was subtracted", "z")
        thin = [self.row(r) for r in rows_of(self.at("wrong/twodgs.ply"))]
        self.flat("wrong/twodgs.ply", thin, "scale_2", "2D Gaussians")
        infinite = [{k: v for k, v in self.row(r).items() if math.isfinite(v)} for r in rows_of(self.at("wrong/scale_minus_inf.ply"))]
        flat_axis = next(k for k in ("scale_0", "scale_1", "scale_2") if k not in infinite[0])
        self.flat("wrong/scale_minus_inf.ply", infinite, flat_axis, "are flat")
        filtered = []
        for r in rows_of(self.at("wrong/mip_filter3d.ply")):
            narrow = [math.exp(2 * r["scale_%d" % k]) for k in range(3)]
            wide = [v + r["filter_3D"] ** 2 for v in narrow]
            opacity = math.sqrt(math.prod(narrow) / math.prod(wide)) / (1 + math.exp(-r["opacity"]))
            opacity = max(opacity, 1e-6)
            filtered.append({**{"scale_%d" % k: 0.5 * math.log(wide[k]) for k in range(3)}, "opacity": math.log(opacity / (1 - opacity))})
        self.holds("wrong/mip_filter3d.ply", filtered, "its filter is folded", tolerances={"scale": 1e-5, "opacity": 1e-3})

        # Of the figure, quantised. A byte is 1/255 of what can be seen of a colour and of an opacity.
        def near(position, scale):
            return {"f_dc": 0.5 / 255 / C0 + 2e-4, "opacity": 0.09, "scale": scale, "x": position, "y": position, "z": position}

        for name in ("plain", "rot_zero_bytes"):
            self.holds("right/%s.splat" % name, figure, tolerances=near(0, 1e-6), decibels=32 if name == "plain" else None)
        alphas = open(self.at("right/alpha0.splat"), "rb").read()[27::32]
        logit = lambda byte: math.log(max(byte / 255, 1e-6) / (1 - max(byte / 255, 1e-6))) if byte < 255 else 13.8
        self.holds("right/alpha0.splat", [dict(r, opacity=logit(a)) for r, a in zip(figure, alphas)], tolerances={**near(0, 1e-6), "opacity": 0.2})
        for name in ("", "_sh1", "_sh3"):
            self.holds("right/super%s.compressed.ply" % name, figure, tolerances=near(9e-4, 5e-4), decibels=32)
        up_y = [dict(r, y=-r["y"], z=-r["z"]) for r in figure]
        half = near(2e-4, 1 / 32 + 1e-3)
        half["f_dc"] = 0.5 / 255 / 0.15 + 1e-4  # spz holds colours as 0.15 f_dc
        for path, said in (("right/v2.spz", ""), ("right/v3.spz", ""), ("wrong/v3_degree4.spz", "degree 4 are left out"), ("wrong/v4.spz", ""),
                           ("wrong/v4_degree4.spz", "degree 4 are left out")):
            self.holds(path, up_y, said, "y", half, 32)
        self.holds("wrong/v3_aa.spz", up_y, "trained with anti-aliasing", "y", half)
        self.holds("wrong/v1.spz", up_y, "", "y", {**half, "x": 1e-3, "y": 1e-3, "z": 1e-3}, 32)
        self.holds("wrong/v3_extension_ydown.spz", figure, "-y is taken as up", "-y", half, 32)
        self.holds("wrong/plain.ply.gz", figure, decibels=100)

        for name, text in (("right/html.ply", "a web page"), ("right/lfs.ply", "git lfs pull"), ("right/mesh.ply", "no property scale_0"),
                           ("right/pointcloud.ply", "a plain point cloud or mesh has no Gaussians"), ("right/rest_48.ply", "48 f_rest_* properties"),
                           ("right/truncated.splat", "12283 bytes"), ("wrong/luma.zip", "splat/point_cloud.ply"),
                           ("wrong/scaffold.ply", "anchors of Scaffold-GS"), ("wrong/scene.ksplat", "a .ksplat file"),
                           # These two have a meta.json alone.
                           ("wrong/scene.sog", "meta.json /means/mins"), ("wrong/sog_folder", "means_l.webp")):
            self.refused(name, text)
        scans = "wrong/my scans/" + next(iter(sorted(os.listdir(self.at("wrong/my scans")))))
        inside = [os.path.join(d, f) for d, _, files in os.walk(self.at("wrong/my scans")) for f in files if f.endswith(".ply")]
        self.holds(os.path.relpath(inside[0], self.cases) if inside else scans, figure, decibels=100)

    def flat(self, name, expected, axis, said):
        self.holds(name, expected, said)
        out = self.run(name, self.at(name))[0]
        for row in exported.read_ply(out + "/gaussians.ply"):
            others = min(row["scale_%d" % k] for k in range(3) if "scale_%d" % k != axis)
            if not (math.isfinite(row[axis]) and row[axis] < others - 5):
                return self.say(name, "%s is %r beside %r" % (axis, row[axis], others))

    def same_cameras(self, name, out, expected):
        """expected: camera-to-world (x right, y up, z back) by the picture's name without folder and ending."""
        scene = json.load(open(out + "/scene.json"))
        chosen = {k[5:]: v for k, v in scene["provenance"]["options"].items() if k.startswith("view ")}
        for view in scene["views"]:
            stem = os.path.splitext(chosen[view["name"]].split(", ")[0].replace("\\", "/").split("/")[-1])[0]
            pose, lens = expected[stem]
            W = view["camera"]["world_to_camera"]
            for r in range(3):
                for c in range(3):
                    # Our axes are x right, y down, z forward, and W is the inverse.
                    if abs(W[c][r] - pose[r][c] * (1, -1, -1)[c]) > 1e-6:
                        return self.say(name, "view %s is turned otherwise" % view["name"])
                if abs(sum(W[r][k] * pose[k][3] for k in range(3)) + W[r][3]) > 1e-5:
                    return self.say(name, "view %s stands elsewhere" % view["name"])
            for key, value in lens.items():
                if abs(view["camera"][key] - value) > 1e-6:
                    return self.say(name, "view %s has %s %r, expected %r" % (view["name"], key, view["camera"][key], value))
        if len(scene["views"]) != 4:
            self.say(name, "%d views" % len(scene["views"]))

    def cameras(self):
        plain = self.at("right/plain.ply")
        with open(self.at("right/cap/transforms.json"), encoding="utf-8-sig") as file:
            capture = json.load(file)
        lens = {"fx": capture["fl_x"], "fy": capture["fl_y"], "width": capture["w"], "height": capture["h"]} if "fl_x" in capture else {}
        poses = {os.path.splitext(os.path.basename(f["file_path"]))[0]: (f["transform_matrix"], lens) for f in capture["frames"]}

        def views(name, pictures, cameras, expected):
            out, status, said = self.run(name, "--views", self.at(pictures), "--cameras", self.at(cameras), plain)
            if status != 0:
                return self.say(name, "exit code %d: %s" % (status, said))
            self.same_cameras(name, out, expected)
            return said

        any_lens = {k: (p, {}) for k, (p, _) in poses.items()}
        for name in ("right/cap/bom.json", "right/cap/dot_no_ext.json", "right/cap/null_angle.json", "right/cap/simple_pinhole.json",
                     "right/cap/transforms.json", "wrong/cap/w2c.json", "wrong/cap/windows.json"):
            views(name, os.path.dirname(name) + "/images", name, poses if name != "right/cap/null_angle.json" else any_lens)
        said = views("wrong/cap/ns_export.json", "wrong/cap/images", "wrong/cap/ns_export.json", any_lens)
        if "no focal length" not in (said or ""):
            self.say("wrong/cap/ns_export.json", "the missing focal length is not said")
        for name in ("right/mix/per_frame_only.json", "right/mix/transforms.json"):
            with open(self.at(name)) as file:
                frames = json.load(file)["frames"]
            mixed = {os.path.splitext(os.path.basename(f["file_path"]))[0]: (f["transform_matrix"], {"width": f["w"], "height": f["h"]} if "w" in f else {})
                     for f in frames}
            views(name, "right/mix/images", name, mixed)
        with open(self.at("right/inria_upper/cameras.json")) as file:
            cameras = json.load(file)
        inria = {c["img_name"].split(".")[0]: ([[*(c["rotation"][r][k] * (1, -1, -1)[k] for k in range(3)), c["position"][r]] for r in range(3)],
                                               {"fx": c["fx"], "width": c["width"]}) for c in cameras}
        views("right/inria_upper", "right/inria_upper/images", "right/inria_upper/cameras.json", inria)
        text = {}
        for line in open(self.at("right/cm_text_spaces/images.txt")):
            words = line.split()
            if len(words) < 10 or line.startswith("#"):
                continue
            w, x, y, z = exported.unit([float(v) for v in words[1:5]])
            R = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                 [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                 [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
            t = [float(v) for v in words[5:8]]
            place = [-sum(R[k][r] * t[k] for k in range(3)) for r in range(3)]
            text[os.path.splitext(line.strip().split(None, 9)[9])[0]] = ([[*(R[k][r] * (1, -1, -1)[k] for k in range(3)), place[r]] for r in range(3)], {})
        views("right/cm_text_spaces", "right/cm_images", "right/cm_text_spaces", text)
        # The same model in binary, with other names.
        binary = {k.replace("my ", "").replace(" ", "_"): v for k, v in text.items()}
        for name in ("cm_full_zero", "cm_gaps", "cm_simple_radial"):
            views("right/" + name, "right/cm_images", "right/" + name, binary)

        for name, text in (("right/cap/equirect.json", "EQUIRECTANGULAR"), ("right/cap/fisheye_flag.json", "/is_fisheye"),
                           ("right/cap/fisheye_model.json", "OPENCV_FISHEYE"), ("right/cap/k4.json", "/k4: found 0.02"),
                           ("right/cap/nan.json", "malformed JSON"), ("right/mix/per_frame_fisheye.json", "/frames/2/camera_model"),
                           ("right/cm_fisheye", "the camera model OPENCV_FISHEYE"), ("right/cm_fov", "the camera model FOV"),
                           ("right/cm_full_k456", "FULL_OPENCV with k4"), ("right/cm_new_model", "camera model 11"),
                           ("right/cm_srf", "SIMPLE_RADIAL_FISHEYE"), ("right/cm_thin", "THIN_PRISM_FISHEYE")):
            pictures = "right/cm_images" if "/cm_" in name else os.path.dirname(name) + "/images"
            self.refused(name, text, "--views", self.at(pictures), "--cameras", self.at(name), plain)

    def configurations(self):
        scene = self.at("right/z_up.ply")
        figure = [self.row(r) for r in rows_of(scene)]

        def taken(name, said, checks, turned=False):
            out, status, text = self.run(name, "--physgaussian", self.at(name), scene)
            if status != 0 or said not in text:
                return self.say(name, "exit code %d, said %r, expected %r" % (status, text, said))
            document = json.load(open(out + "/scene.json"))
            for pointer, expected in checks.items():
                value = document["run"]
                for word in pointer.split("/"):
                    value = value[int(word) if word.isdigit() else word]
                if value != expected:
                    self.say(name, "%s is %r, expected %r" % (pointer, value, expected))
            got = exported.read_ply(out + "/gaussians.ply")
            if turned:
                # Turned as a whole: distances stay, places do not.
                apart = lambda rows: [math.dist([a[k] for k in "xyz"], [b[k] for k in "xyz"]) for a, b in zip(rows, rows[7:])]
                if max(abs(a - b) for a, b in zip(apart(got), apart(figure))) > 1e-5 or abs(got[3]["x"] - figure[3]["x"]) < 1e-3:
                    self.say(name, "is not turned")
            else:
                self.compare(name, got, figure, {})

        def asked(name):
            with open(self.at(name)) as file:
                text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
            return json.loads(re.sub(r"(?m)^(\s*)//.*$|(?<=[,{\[0-9\"\]}])\s*//[^\n]*$", "", text))

        for name, said, turned in (("right/pg/base.json", "", False), ("right/pg/soft_E.json", "clipped to the range of Rubber", False),
                                   ("right/pg/two_rotations.json", "turned: ", True), ("wrong/pg/comments.json", "", False),
                                   ("wrong/pg/correct_spelling.json", "", False),
                                   ("wrong/pg/floor_through_object.json", "goes through the scene", False)):
            data = asked(name)
            checks = {"grid/n": data["n_grid"], "time/substep_dt": data["substep_dt"], "time/frame_dt": data["frame_dt"]}
            taken(name, said, {k: v for k, v in checks.items() if k != "grid/n" or data.get("grid_lim", 2) == 2}, turned)
        for name, text in (("right/pg/fluid.json", '/material: found "fluid"'), ("right/pg/nu_half.json", "/nu: found 0.5"),
                           ("right/pg/rotation_mismatch.json", "/rotation_axis"), ("right/pg/trailing_comma.json", "malformed JSON"),
                           ("right/pg/sim_area_outside.json", "none of 384 Gaussians")):
            self.refused(name, text, "--physgaussian", self.at(name), scene)


if __name__ == "__main__":
    cases = Cases(*sys.argv[1:4])
    getattr(cases, sys.argv[4])()
    print("\n".join(cases.wrong))
    sys.exit(1 if cases.wrong else 0)
