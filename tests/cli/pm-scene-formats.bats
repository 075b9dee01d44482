#!/usr/bin/env bats
# pm-scene with the files of other programs.

bats_require_minimum_version 1.5.0

load common
load tiny-ball

setup_file() {
  make_tiny_ball
}

setup() {
  OUT="$BATS_TEST_TMPDIR/out"
}

import() {
  "$BIN/pm-scene" import "$TINY/gaussians.ply" --prompt "it falls" --up z --out "$OUT" "$@"
}

# foreign KIND: the four cameras of the tiny bundle as another program writes them, in the order left, back, right, front.
foreign() {
  python3 - "$1" "$TINY/scene.json" "$BATS_TEST_TMPDIR" <<'PY'
import json, math, os, sys
kind, scene, folder = sys.argv[1:]
views = json.load(open(scene))["views"][::-1]
frames, cameras = [], []
for i, v in enumerate(views):
    c = v["camera"]
    W = c["world_to_camera"]
    R = [[W[k][r] for k in range(3)] for r in range(3)]  # camera to world
    p = [-sum(R[r][k] * W[k][3] for k in range(3)) for r in range(3)]
    frames.append({"file_path": "views/" + v["name"], "w": c["width"], "h": c["height"], "fl_x": c["fx"], "fl_y": c["fy"],
                   "transform_matrix": [[R[r][0], -R[r][1], -R[r][2], p[r]] for r in range(3)] + [[0, 0, 0, 1]]})
    cameras.append({"id": i, "img_name": v["name"], "width": c["width"], "height": c["height"], "fx": c["fx"], "fy": c["fy"],
                    "position": p, "rotation": R})
if kind == "transforms":
    json.dump({"frames": frames}, open(folder + "/transforms.json", "w"))
if kind == "splatting":
    json.dump(cameras, open(folder + "/cameras.json", "w"))
if kind == "colmap":
    os.makedirs(folder + "/sparse/0")
    with open(folder + "/sparse/0/cameras.txt", "w") as out:
        c = views[0]["camera"]
        print("# cameras\n1 PINHOLE", c["width"], c["height"], c["fx"], c["fy"], c["cx"], c["cy"], file=out)
    with open(folder + "/sparse/0/images.txt", "w") as out:
        for i, v in enumerate(views):
            W = v["camera"]["world_to_camera"]
            q = [1 + W[0][0] + W[1][1] + W[2][2], W[2][1] - W[1][2], W[0][2] - W[2][0], W[1][0] - W[0][1]]
            n = math.sqrt(sum(x * x for x in q))
            print(i + 1, *[x / n for x in q], *[W[r][3] for r in range(3)], 1, v["name"] + ".png\n", file=out)
PY
}

# The bundle's views are the tiny bundle's, by name, image and camera.
same_views() {
  python3 - "$TINY/scene.json" "$OUT/scene.json" <<'PY'
import json, sys
a, b = (json.load(open(f))["views"] for f in sys.argv[1:])
for x, y in zip(a, b, strict=True):
    assert x["name"] == y["name"], (x["name"], y["name"])
    for key in ("width", "height", "fx", "fy", "cx", "cy"):
        assert abs(x["camera"][key] - y["camera"][key]) < 1e-6, key
    for r in range(3):
        for c in range(4):
            # The poses go through text and, for COLMAP, a quaternion.
            assert abs(x["camera"]["world_to_camera"][r][c] - y["camera"]["world_to_camera"][r][c]) < 1e-6
PY
  for name in front right back left; do cmp "$TINY/views/$name.png" "$OUT/views/$name.png"; done
}

@test "cameras of nerfstudio, 3DGS and COLMAP give the same four views" {
  foreign transforms
  import --views "$TINY" --cameras "$BATS_TEST_TMPDIR/transforms.json"
  same_views
  grep -q '"view front": "views/front, ' "$OUT/scene.json"
  foreign splatting
  import --views "$TINY/views" --cameras "$BATS_TEST_TMPDIR/cameras.json"
  same_views
  foreign colmap
  import --views "$TINY/views" --cameras "$BATS_TEST_TMPDIR/sparse/0"
  same_views
  grep -q 'sparse/0/images.txt"' "$OUT/scene.json"
  import --views "$TINY/views" --cameras "$BATS_TEST_TMPDIR/sparse/0/images.txt"
  same_views
}

@test "cameras of a capture follow nerfstudio's dataparser_transforms.json to its splat" {
  foreign transforms
  # The capture is smaller, turned and elsewhere; nerfstudio's frame is the one of the Gaussians.
  mkdir "$BATS_TEST_TMPDIR/data" "$BATS_TEST_TMPDIR/export"
  python3 - "$BATS_TEST_TMPDIR" <<'PY'
import json, sys
folder = sys.argv[1]
data = json.load(open(folder + "/transforms.json"))
s, R, t = 4.0, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], [0.25, -3, 1]
A = [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]]  # ns-process-data's
for f in data["frames"]:
    m = f["transform_matrix"]
    y = [[m[r][c] if c < 3 else m[r][3] / s - t[r] for c in range(4)] for r in range(3)]
    x = [[sum(R[k][r] * y[k][c] for k in range(3)) for c in range(4)] for r in range(3)]
    f["transform_matrix"] = [[sum(A[r][k] * x[k][c] for k in range(3)) for c in range(4)] for r in range(3)] + [[0, 0, 0, 1]]
data["applied_transform"] = A
json.dump(data, open(folder + "/data/transforms.json", "w"))
json.dump({"transform": [R[r] + [t[r]] for r in range(3)], "scale": s}, open(folder + "/dataparser_transforms.json", "w"))
PY
  cp "$TINY/gaussians.ply" "$BATS_TEST_TMPDIR/export/splat.ply"
  cameras=(--views "$TINY" --cameras "$BATS_TEST_TMPDIR/data/transforms.json")
  import "${cameras[@]}" --dataparser-transforms "$BATS_TEST_TMPDIR/dataparser_transforms.json"
  same_views
  # Beside the splat, and with it z is up without saying so.
  cp "$BATS_TEST_TMPDIR/dataparser_transforms.json" "$BATS_TEST_TMPDIR/export"
  rm -r "$OUT"
  "$BIN/pm-scene" import "$BATS_TEST_TMPDIR/export/splat.ply" --prompt "it falls" --out "$OUT" "${cameras[@]}"
  same_views
  grep -q 'export/dataparser_transforms.json"' "$OUT/scene.json"
  grep -q '"up": "z"' "$OUT/scene.json"
  # Not wanted, not whole, without cameras, and with cameras that need none.
  run -3 "$BIN/pm-scene" import "$BATS_TEST_TMPDIR/export/splat.ply" --prompt "it falls" --up z --out "$OUT" \
    "${cameras[@]}" --dataparser-transforms none
  [[ "$output" == *"same coordinates as the Gaussians"* ]]
  echo '{"scale": 1}' > "$BATS_TEST_TMPDIR/export/dataparser_transforms.json"
  run -3 "$BIN/pm-scene" import "$BATS_TEST_TMPDIR/export/splat.ply" --prompt "it falls" --out "$OUT" "${cameras[@]}"
  [[ "$output" == *"dataparser_transforms.json: /transform"* ]]
  run -2 import --dataparser-transforms "$BATS_TEST_TMPDIR/dataparser_transforms.json"
  python3 - "$TINY/scene.json" > "$BATS_TEST_TMPDIR/own.json" <<'PY'
import json, sys
print(json.dumps(json.load(open(sys.argv[1]))["views"]))
PY
  run -2 import --views "$TINY" --cameras "$BATS_TEST_TMPDIR/own.json" \
    --dataparser-transforms "$BATS_TEST_TMPDIR/dataparser_transforms.json"
  [[ "$output" == *"own.json"* ]]
}

@test "pictures of lenses with distortion are undistorted" {
  foreign transforms
  sed -i 's/{"frames"/{"k1": -0.15, "p2": 0.01, "frames"/' "$BATS_TEST_TMPDIR/transforms.json"
  import --views "$TINY" --cameras "$BATS_TEST_TMPDIR/transforms.json"
  refute cmp "$TINY/views/front.png" "$OUT/views/front.png"
  foreign colmap
  sed -i 's/PINHOLE\(.*\)/OPENCV\1 -0.15 0 0 0.01/' "$BATS_TEST_TMPDIR/sparse/0/cameras.txt"
  cp "$OUT/views/front.png" "$BATS_TEST_TMPDIR/front.png"
  import --views "$TINY/views" --cameras "$BATS_TEST_TMPDIR/sparse/0"
  cmp "$BATS_TEST_TMPDIR/front.png" "$OUT/views/front.png"
  grep -q '"image": "views/front.png"' "$OUT/scene.json"
}

@test "fisheyes, folded and missing images are refused and nothing is written" {
  foreign colmap
  sed -i 's/PINHOLE\(.*\)/OPENCV_FISHEYE\1 0.1 0 0 0/' "$BATS_TEST_TMPDIR/sparse/0/cameras.txt"
  run -3 import --views "$TINY/views" --cameras "$BATS_TEST_TMPDIR/sparse/0"
  [[ "$output" == *"cameras.txt: line 2"*image_undistorter* ]]
  foreign transforms
  run -3 import --views "$BATS_TEST_TMPDIR" --cameras "$BATS_TEST_TMPDIR/transforms.json"
  [[ "$output" == *"the image \"views/"* ]]
  sed -i 's/{"frames"/{"k1": -20, "frames"/' "$BATS_TEST_TMPDIR/transforms.json"
  run -3 import --views "$TINY" --cameras "$BATS_TEST_TMPDIR/transforms.json"
  [[ "$output" == *"transforms.json: /k1: "*"folds"* ]]
  [ ! -e "$OUT" ]
}

@test "opacity threshold and crop are applied and recorded" {
  import --crop -1 1 -1 1 -1 0 --opacity-threshold 0.01
  grep -q '"crop": "-1 1 -1 1 -1 0"' "$OUT/scene.json"
  grep -q '"opacity_threshold": "0.01"' "$OUT/scene.json"
  removed=$(sed -n 's/.*"gaussians_removed": "\([0-9]*\)".*/\1/p' "$OUT/scene.json")
  whole=$("$BIN/pm-scene" info "$TINY/gaussians.ply" | sed -n '1s/.*: \([0-9]*\) Gaussians/\1/p')
  left=$("$BIN/pm-scene" info "$OUT/gaussians.ply" | sed -n '1s/.*: \([0-9]*\) Gaussians/\1/p')
  [ "$left" -gt 0 ]
  [ "$removed" -gt 0 ]
  [ $((left + removed)) -eq "$whole" ]
  rm -r "$OUT"
  run -3 import --crop 5 6 5 6 5 6
  [[ "$output" == *"none of"* ]]
  run -2 import --crop 1 0 0 1 0 1
  run -2 import --crop 1 2 3
  [ ! -e "$OUT" ]
}

@test "info prints histograms and warns of floaters on stderr" {
  run --separate-stderr "$BIN/pm-scene" info "$TINY/gaussians.ply"
  [ "$status" -eq 0 ]
  [[ "$output" == *"opacity "*"###"*"scale "*"###"*"floaters"* ]]
  [ -z "$stderr" ]
  # The first Gaussian's x, moved to 100. With fewer than 200 Gaussians one would not be a stray.
  sed 's/0.15/0.05/' "$BATS_FILE_TMPDIR/tiny.json" > "$BATS_TEST_TMPDIR/fine.json"
  "$BIN/pm-scene" synth "$BATS_TEST_TMPDIR/fine.json" --out "$BATS_TEST_TMPDIR/fine"
  python3 - "$BATS_TEST_TMPDIR/fine/gaussians.ply" "$BATS_TEST_TMPDIR/far.ply" <<'PY'
import struct, sys
b = bytearray(open(sys.argv[1], "rb").read())
at = b.index(b"end_header\n") + 11
b[at:at + 4] = struct.pack("<f", 100)
open(sys.argv[2], "wb").write(b)
PY
  run --separate-stderr "$BIN/pm-scene" info "$BATS_TEST_TMPDIR/far.ply"
  [ "$status" -eq 0 ]
  [[ "$stderr" == *"1 floaters"*"--crop"* ]]
}

@test "a PhysGaussian configuration becomes the run specification; the rest is named and recorded" {
  cat > "$BATS_TEST_TMPDIR/config.json" <<'JSON'
{"opacity_threshold": 0.02, "material": "jelly", "E": 2e6, "nu": 0.4, "density": 200, "g": [0, 0, -9.8], "n_grid": 50,
 "grid_lim": 2, "substep_dt": 1e-4, "frame_dt": 4e-2, "frame_num": 20, "boundary_conditions": [{"type": "bounding_box"},
 {"type": "cuboid", "point": [1, 1, 0.5], "size": [0.5, 0.5, 0.1], "velocity": [0, 0, 0]},
 {"type": "particle_impulse", "force": [-0.18, 0, 0]}], "delta_a": 0.4}
JSON
  run --separate-stderr "$BIN/pm-scene" import "$TINY/gaussians.ply" --prompt "it falls" --out "$OUT" \
    --physgaussian "$BATS_TEST_TMPDIR/config.json"
  [ "$status" -eq 0 ]
  [[ "$output" == *"not mapped: /density: "* ]]
  [[ "$output" == *"not mapped: /boundary_conditions/2 (particle_impulse): "* ]]
  [[ "$output" == *"not mapped: /delta_a: "* ]]
  grep -q '"not mapped /delta_a": ' "$OUT/scene.json"
  grep -q '"label": "Rubber"' "$OUT/material-records.json"
  run "$BIN/pm-scene" info "$OUT/scene.json"
  [[ "$output" == *"for 21 frames"*"50 cells"*"up z, 1 colliders"* ]]
  rm -r "$OUT"
  run -2 import --up y --physgaussian "$BATS_TEST_TMPDIR/config.json"
  echo '{"material": "water"}' > "$BATS_TEST_TMPDIR/config.json"
  run -3 import --physgaussian "$BATS_TEST_TMPDIR/config.json"
  [[ "$output" == *"/material"* ]]
  [ ! -e "$OUT" ]
}

@test "a PhysGaussian rotation turns the scene, its cameras with it" {
  echo '{"rotation_degree": [30, -20.5], "rotation_axis": [2, 0], "g": [0, 0, -9.8], "opacity_threshold": 0, "sim_area":
    [-9, 9, -9, 9, -9, 9], "boundary_conditions": [{"type": "cuboid", "point": [1, 1, 0.5], "size": [0.5, 0.5, 0.1],
    "velocity": [0, 0, 0]}]}' > "$BATS_TEST_TMPDIR/config.json"
  python3 -c 'import json, sys; print(json.dumps(json.load(open(sys.argv[1]))["views"]))' "$TINY/scene.json" \
    > "$BATS_TEST_TMPDIR/cameras.json"
  run --separate-stderr "$BIN/pm-scene" import "$TINY/gaussians.ply" --prompt "it falls" --out "$OUT" --views "$TINY" \
    --cameras "$BATS_TEST_TMPDIR/cameras.json" --physgaussian "$BATS_TEST_TMPDIR/config.json"
  [ "$status" -eq 0 ]
  [[ "$output" == *"turned: "*" degrees about "* ]]
  [[ "$output" != *"rotation_degree"* ]]
  grep -q '"turned": ".* degrees about ' "$OUT/scene.json"
  python3 - "$TINY" "$OUT" <<'PY'
import json, math, struct, sys
def turn(p):
    a, b = math.radians(30), math.radians(-20.5)
    x, y, z = math.cos(a) * p[0] - math.sin(a) * p[1], math.sin(a) * p[0] + math.cos(a) * p[1], p[2]
    return x, math.cos(b) * y - math.sin(b) * z, math.sin(b) * y + math.cos(b) * z
def means(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    count = data[:end].count(b"property float")
    for at in range(end, len(data), 4 * count):
        yield struct.unpack_from("<3f", data, at)
def cameras(path):
    for view in json.load(open(path))["views"]:
        yield view["camera"]["world_to_camera"]
def along(m, p):
    m = [m[4 * i:4 * i + 4] for i in range(4)] if len(m) == 16 else m
    return [sum(m[i][k] * p[k] for k in range(3)) + m[i][3] for i in range(3)]
close = lambda a, b: all(abs(x - y) < 1e-5 for x, y in zip(a, b))
before, after = list(means(sys.argv[1] + "/gaussians.ply")), list(means(sys.argv[2] + "/gaussians.ply"))
assert len(before) == len(after) > 0
assert all(close(turn(p), q) for p, q in zip(before, after))
for m, n in zip(cameras(sys.argv[1] + "/scene.json"), cameras(sys.argv[2] + "/scene.json")):
    assert all(close(along(m, p), along(n, turn(p))) for p in before[:50])
run = json.load(open(sys.argv[2] + "/scene.json"))["run"]
assert run["gravity"] == [0, 0, -9.8] and run["placement"]["up"] == "z", run
assert close(run["colliders"][0]["min"], (0.5, 0.5, 0.4)), run["colliders"]
PY
}

@test "an spz file is imported with y up" {
  python3 - "$TINY/gaussians.ply" "$BATS_TEST_TMPDIR/ball.spz" <<'PY'
import gzip, math, struct, sys
n = 60
body = b"NGSP" + struct.pack("<IIBBBB", 3, n, 0, 12, 0, 0)
for i in range(n):
    a, h = i * 2.4, i / n - 0.5
    for p in (math.cos(a) * 0.5, h, math.sin(a) * 0.5):
        body += struct.pack("<i", int(p * 4096))[:3]
body += bytes([230] * n) + bytes([200, 100, 50] * n) + bytes([110] * 3 * n) + struct.pack("<I", 3 << 30) * n
open(sys.argv[2], "wb").write(gzip.compress(body))
PY
  "$BIN/pm-scene" import "$BATS_TEST_TMPDIR/ball.spz" --prompt "it falls" --out "$OUT"
  run "$BIN/pm-scene" info "$OUT/scene.json"
  [[ "$output" == *"up y"*"60 Gaussians"* ]]
  head -c 200 "$BATS_TEST_TMPDIR/ball.spz" > "$BATS_TEST_TMPDIR/cut.spz"
  run -3 "$BIN/pm-scene" import "$BATS_TEST_TMPDIR/cut.spz" --prompt x --out "$OUT"
  [[ "$output" == *"cut.spz"*"cut off"* ]]
}
