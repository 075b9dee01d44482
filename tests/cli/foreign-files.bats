#!/usr/bin/env bats
# Files that people have had trouble with elsewhere, through pm-scene import: what the bundle then holds and looks like.

bats_require_minimum_version 1.5.0

load common

setup_file() {
  export FILES="$BATS_FILE_TMPDIR"
  python3 "$BATS_TEST_DIRNAME/foreign_files.py" "$FILES"
  # What the others are compared with.
  "$bin/pm-scene" import "$FILES/plain.ply" --prompt "it falls" --out "$FILES/plain"
}

setup() {
  OUT="$BATS_TEST_TMPDIR/out"
}

import() {
  "$bin/pm-scene" import --prompt "it falls" --out "$OUT" "$@"
}

# recorded KEY VALUE: of the provenance's options.
recorded() {
  python3 - "$OUT/scene.json" "$@" <<'PY'
import json, sys
options = json.load(open(sys.argv[1]))["provenance"]["options"]
assert options.get(sys.argv[2]) == sys.argv[3], options
PY
}

# same_views FOLDER: the views are those of the scene in FOLDER.
same_views() {
  for name in front right back left; do cmp "$1/views/$name.png" "$OUT/views/$name.png"; done
}

# alike DECIBELS: the front view is the plain scene's but for so little.
alike() {
  python3 "$BATS_TEST_DIRNAME/foreign_files.py" psnr "$FILES/plain/views/front.png" "$OUT/views/front.png" "$1"
}

@test "the vertical axis that a file names is up, but --up wins" {
  run --separate-stderr import "$FILES/nerfstudio_z.ply"
  [ "$status" -eq 0 ]
  [[ "$stderr" == *"Vertical Axis: z"*"z is taken as up"* ]]
  recorded up z
  import "$FILES/nerfstudio_z.ply" --up y
  recorded up y
  # Another way up and the same figure: the front view is that of the figure with y down.
  import "$FILES/nerfstudio_z.ply"
  alike 50
}

@test "an axis that Brush writes into every file is named and not followed" {
  run --separate-stderr import "$FILES/brush_y.ply"
  [ "$status" -eq 0 ]
  [[ "$stderr" == *"Vertical axis: y"*"not followed"*"--up y"* ]]
  recorded up -y
}

@test "Gaussians that no renderer draws are dropped, counted and recorded; many are refused" {
  run --separate-stderr import "$FILES/nan_few.ply"
  [ "$status" -eq 0 ]
  [[ "$stderr" == *"warning: "*"3 of 387 Gaussians were dropped"* ]]
  recorded gaussians_dropped 3
  same_views "$FILES/plain"
  rm -r "$OUT"
  run -3 import "$FILES/nan_many.ply"
  [[ "$output" == *"--read drop-broken"* ]]
  [ ! -e "$OUT" ]
  import "$FILES/nan_many.ply" --read drop-broken
  recorded gaussians_dropped 40
  same_views "$FILES/plain"
}

@test "far offsets are subtracted in doubles and recorded, and a crop and cameras are in the file's coordinates" {
  import "$FILES/utm_double.ply"
  recorded up z
  import "$FILES/utm_double.ply" --up=-y
  recorded offset "431000 5412000 213"
  alike 50
  import "$FILES/utm_double.ply" --up=-y --crop 430999.9 431002 5411990 5412010 200 220
  python3 - "$OUT/scene.json" <<'PY'
import json, sys
options = json.load(open(sys.argv[1]))["provenance"]["options"]
assert 0 < int(options["gaussians_removed"]) < 300, options
assert options["crop"].startswith("430999.9 431002 "), options
PY
  mkdir "$BATS_TEST_TMPDIR/images"
  cp "$FILES"/plain/views/*.png "$BATS_TEST_TMPDIR/images"
  python3 - "$FILES/plain/scene.json" "$BATS_TEST_TMPDIR/cameras.json" <<'PY'
import json, sys
views = json.load(open(sys.argv[1]))["views"]
for view in views:
    W = view["camera"]["world_to_camera"]
    for r in range(3):
        W[r][3] -= sum(W[r][c] * o for c, o in enumerate((431000, 5412000, 213)))
    view["image"] = view["name"] + ".png"
json.dump(views, open(sys.argv[2], "w"))
PY
  import "$FILES/utm_double.ply" --up=-y --views "$BATS_TEST_TMPDIR/images" --cameras "$BATS_TEST_TMPDIR/cameras.json"
  python3 - "$FILES/plain/scene.json" "$OUT/scene.json" <<'PY'
import json, sys
for a, b in zip(*(json.load(open(f))["views"] for f in sys.argv[1:]), strict=True):
    for r in range(3):
        for c in range(4):
            assert abs(a["camera"]["world_to_camera"][r][c] - b["camera"]["world_to_camera"][r][c]) < 1e-6
PY
}

@test "a sky around a small object is one warning, and --crop auto takes the object" {
  for file in sky_few sky_many; do
    run --separate-stderr import "$FILES/$file.ply"
    [ "$status" -eq 0 ]
    [ "$(grep -c warning <<<"$stderr")" -eq 1 ]
    [[ "$stderr" == *"--crop auto takes it alone"* ]]
    run --separate-stderr import --crop auto "$FILES/$file.ply"
    [ "$status" -eq 0 ]
    refute grep -q warning <<<"$stderr"
    same_views "$FILES/plain"
    # Wherever the words stand.
    "$bin/pm-scene" import --crop auto "$FILES/$file.ply" --prompt "it falls" --out "$OUT"
    same_views "$FILES/plain"
    # What it took can be asked for again.
    crop=$(sed -n 's/.*"crop": "\(.*\)".*/\1/p' "$OUT/scene.json")
    rm -r "$OUT"
    import "$FILES/$file.ply" --crop $crop
    same_views "$FILES/plain"
  done
}

@test "a scene among floaters is one warning, and --crop auto takes it with what few floaters lie in its box" {
  cd "$BATS_TEST_TMPDIR" || return 1
  "$bin/pm-scene" synth "$root/examples/cake.json" --out cake --quiet
  python3 "$BATS_TEST_DIRNAME/foreign_files.py" floaters cake/gaussians.ply floaters.ply
  run --separate-stderr import floaters.ply --up z
  [ "$status" -eq 0 ]
  [ "$(grep -c warning <<<"$stderr")" -eq 1 ]
  [[ "$stderr" == *"--crop auto takes it alone"* ]]
  run --separate-stderr import floaters.ply --up z --crop auto
  [ "$status" -eq 0 ]
  refute grep -q warning <<<"$stderr"
  python3 "$BATS_TEST_DIRNAME/foreign_files.py" kept cake/gaussians.ply floaters.ply "$OUT/gaussians.ply" 200
  # The note counts what is taken.
  taken=$(sed -n 's/element vertex //p;/end_header/q' "$OUT/gaussians.ply")
  [[ "$stderr" == *"takes $taken of 14981 Gaussians"* ]]
}

@test "views that are blank or of one colour are a warning that names cause and option" {
  run --separate-stderr import "$FILES/linear_scale.ply"
  [[ "$stderr" == *"without the logarithm: --read linear-scales"* ]]
  run --separate-stderr import "$FILES/linear_scale.ply" --read linear-scales
  [ -z "$stderr" ]
  alike 45
  run --separate-stderr import "$FILES/faint.ply"
  [[ "$stderr" == *"opacity below 0.0067"*"--opacity-threshold"* ]]
  run --separate-stderr import "$FILES/one.ply"
  [[ "$stderr" == *"one Gaussian only"* ]]
  run --separate-stderr import "$FILES/plain.ply"
  [ -z "$stderr" ]
}

@test "flat, anti-aliased, cut and packed files look as they should" {
  import "$FILES/trailing.ply"
  same_views "$FILES/plain"
  import "$FILES/plain.ply.gz"
  same_views "$FILES/plain"
  import "$FILES/degree4.ply"
  alike 50
  import "$FILES/UPPER.PLY"
  same_views "$FILES/plain"
  # As Gaussians that are too thin to see, which the plain ones are not.
  local file
  for file in twodgs:thin_2 scale_minus_inf:thin_1; do
    "$bin/pm-scene" import "$FILES/${file#*:}.ply" --prompt "it falls" --out "$BATS_TEST_TMPDIR/thin"
    import "$FILES/${file%%:*}.ply"
    python3 "$BATS_TEST_DIRNAME/foreign_files.py" psnr "$BATS_TEST_TMPDIR/thin/views/front.png" "$OUT/views/front.png" 45
    refute cmp -s "$FILES/plain/views/front.png" "$OUT/views/front.png"
  done
  # Compensated splats are fainter, and the bundle remembers it.
  import "$FILES/antialiased.ply"
  refute cmp -s "$FILES/plain/views/front.png" "$OUT/views/front.png"
  alike 25
  "$bin/pm-scene" info "$OUT/gaussians.ply" | grep -q "anti-aliased"
}

@test "other containers are refused by name, and nothing is written" {
  local file
  for file in scaffold.ply:Scaffold-GS scene.ksplat:splat-transform luma.zip:point_cloud.ply photo.jpg:"trained splat" photos:"trained splat"; do
    run -3 import "$FILES/${file%%:*}"
    [[ "$output" == *"${file#*:}"* ]]
  done
  [ ! -e "$OUT" ]
}

# transforms of the plain scene's own views.
poses() {
  python3 "$BATS_TEST_DIRNAME/foreign_files.py" poses "$1" "$FILES/plain/scene.json" "$BATS_TEST_TMPDIR"
}

same_poses() {
  python3 - "$FILES/plain/scene.json" "$OUT/scene.json" <<'PY'
import json, sys
for a, b in zip(*(json.load(open(f))["views"] for f in sys.argv[1:]), strict=True):
    for key in ("fx", "fy", "cx", "cy", "width", "height"):
        assert abs(a["camera"][key] - b["camera"][key]) < 1e-6, key
    for r in range(3):
        for c in range(4):
            assert abs(a["camera"]["world_to_camera"][r][c] - b["camera"]["world_to_camera"][r][c]) < 1e-6
PY
}

@test "world-to-camera lists, ns-export's and paths of Windows give the same cameras" {
  local kind
  for kind in w2c w2c_list windows ns_export; do
    poses $kind
    import "$FILES/plain.ply" --views "$FILES/plain/views" --cameras "$BATS_TEST_TMPDIR/$kind.json"
    same_poses
    same_views "$FILES/plain"
  done
  # Without the capture's transforms.json nothing says the focal length.
  rm "$BATS_TEST_TMPDIR/transforms.json"
  run --separate-stderr import "$FILES/plain.ply" --views "$FILES/plain/views" --cameras "$BATS_TEST_TMPDIR/ns_export.json"
  [ "$status" -eq 0 ]
  [[ "$stderr" == *"no focal length"*transforms.json* ]]
}

@test "PhysGaussian configurations may have comments and either spelling, and a plane through the scene is a warning" {
  cat >"$BATS_TEST_TMPDIR/config.json" <<'JSON'
{ // a comment
 "opacity_threshold": 0.02, "substep_dt": 0.0001, "frame_dt": 0.04, "frame_num": 40, /* "E": 3, */
 "E": 2000000.0, "nu": 0.4, "material": "jelly", "density": 200, "g": [0, 0, -9.8], "grid_lim": 2.0, "n_grid": 50,
 "particle_filling": {"max_particles_num": 123456, "max_particles_per_cell": 4},
 "boundary_conditions": [{"type": "surface_collider", "point": [1, 1, HEIGHT], "normal": [0, 0, 1], "surface": "sticky",
                          "friction": 0.0, "start_time": 0, "end_time": 1000.0}],
 "mpm_space_vertical_upward_axis": [0, 0, 1]
}
JSON
  sed -i 's/HEIGHT/1.0/' "$BATS_TEST_TMPDIR/config.json"
  run --separate-stderr import "$FILES/nerfstudio_z.ply" --physgaussian "$BATS_TEST_TMPDIR/config.json"
  [ "$status" -eq 0 ]
  [[ "$stderr" == *"goes through the scene"*"lie behind it"* ]]
  grep -q '"max": 123456' "$OUT/scene.json"
  grep -q '"per_cell": 4' "$OUT/scene.json"
  sed -i 's/\[1, 1, 1.0\]/[1, 1, 0.3]/' "$BATS_TEST_TMPDIR/config.json"
  run --separate-stderr import "$FILES/nerfstudio_z.ply" --physgaussian "$BATS_TEST_TMPDIR/config.json"
  [ "$status" -eq 0 ]
  [[ "$stderr" != *"goes through"* ]]
}

@test "a large file is read piece by piece" {
  # 200,000 Gaussians of degree 3: 50 MB as a file and as much in memory, of which there is one copy.
  run python3 - "$FILES/large.ply" "$bin/pm-scene" "$OUT" <<'PY'
import random, resource, struct, subprocess, sys
path, program, out = sys.argv[1:]
draw = random.Random(1)
names = ["x", "y", "z", "nx", "ny", "nz"] + [f"f_dc_{k}" for k in range(3)] + [f"f_rest_{k}" for k in range(45)]
names += ["opacity"] + [f"scale_{k}" for k in range(3)] + [f"rot_{k}" for k in range(4)]
rows = b"".join(struct.pack("<62f", *[draw.uniform(-1, 1) for _ in range(3)], *[0] * 51, 2, -5, -5, -5, 1, 0, 0, 0) for _ in range(2000))
with open(path, "wb") as file:
    file.write(("ply\nformat binary_little_endian 1.0\nelement vertex 200000\n" +
                "".join(f"property float {n}\n" for n in names) + "end_header\n").encode())
    for _ in range(100):
        file.write(rows)
def peak(file):
    # One process for each: the peak is that of all children so far.
    code = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); " \
           "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024)"
    command = [program, "import", file, "--prompt", "it falls", "--out", out, "--threads", "1"]
    return int(subprocess.run([sys.executable, "-c", code, *command], check=True, stdout=subprocess.PIPE).stdout)
base, large = peak(path.replace("large", "plain")), peak(path)
print(base, large)
# 236 bytes of each Gaussian, and what rendering takes: 110. Another copy would be 45 MiB more.
assert large - base < 85, (base, large)
PY
  echo "$output"
  [ "$status" -eq 0 ]
  rm "$FILES/large.ply"
}
