load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

@test "pm-render: help and usage" {
  shows_help pm-render
  fails_with 2 "$bin/pm-render" -- "--scene"
  fails_with 2 render --frames 0-10 -- "--frames" "below 10"
  fails_with 2 render --frames x -- "--frames"
  fails_with 2 render --labels labels.mp4 -- "--inventory"
  fails_with 2 render --out video.avi -- ".mp4"
}

@test "pm-render: a video with every frame, a record, frames as PNG" {
  render --png png
  grep -q '"frames_written": 10' videos/support-stiff.json
  [ "$(ls png | wc -l)" -eq 10 ]
  [ "$(head -c 8 png/frame_0005.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]
  [ "$(stat -c %s videos/support-stiff.mp4)" -gt 1000 ]
}

@test "pm-render: one 3DGS file per frame; frame 0 is the scene, filled particles are not written" {
  render --ply ply --threads 1
  [ "$(ls ply | wc -l)" -eq 10 ]
  python3 - bundle/gaussians.ply ply/frame_0000.ply ply/frame_0009.ply <<'PY'
import struct, sys
def read(path):
    data = open(path, "rb").read()
    head, body = data.split(b"end_header\n", 1)
    names = [l.split()[2].decode() for l in head.splitlines() if l.startswith(b"property")]
    rows = [dict(zip(names, r)) for r in struct.iter_unpack("<%df" % len(names), body)]
    return rows
scene, first, last = map(read, sys.argv[1:])
assert len(scene) == len(first) == len(last)
for a, b in zip(scene, first):
    for name in a:
        # Positions took a way through the solver's float32.
        assert abs(a[name] - b[name]) <= (1e-5 if name in "xyz" else 0), (name, a[name], b[name])
assert any(abs(a["z"] - b["z"]) + abs(a["y"] - b["y"]) > 1e-3 for a, b in zip(first, last))
assert all(a["opacity"] == b["opacity"] for a, b in zip(first, last))
PY
  "$bin/pm-scene" info ply/frame_0009.ply | grep -q Gaussians
  before=$(fingerprint ply)
  render --ply ply --threads 3
  [ "$(fingerprint ply)" = "$before" ]
}

@test "pm-render: frames of an earlier, longer run go; files of the user's stay" {
  render --png out --ply out --depth out
  [ "$(ls out | wc -l)" -eq 30 ]
  touch out/frame_0099.png out/frame_12345.ply out/depth_0099.png
  kept="frame_7.png frame_0009.jpg frame_00099.png frame_0099.png.bak my_frame_0099.png notes.txt"
  (cd out; touch $kept; mkdir frame_0098.png; ln -s ../state.h5 frame_0097.png)
  render --png out --ply out --frames 0-3,6
  [ "$(cd out && echo frame_000[0-9].png)" = "$(printf 'frame_000%d.png ' 0 1 2 3 6 | sed 's/ $//')" ]
  [ "$(cd out && echo frame_000[0-9].ply)" = "$(printf 'frame_000%d.ply ' 0 1 2 3 6 | sed 's/ $//')" ]
  [ ! -e out/frame_0099.png ]
  [ ! -e out/frame_12345.ply ]
  # Not asked for this time, so not touched.
  [ "$(ls out/depth_* | wc -l)" -eq 11 ]
  for file in $kept; do [ -e "out/$file" ]; done
  [ -d out/frame_0098.png ]
  [ -L out/frame_0097.png ]
  refute grep tmp <(ls -A out)
}

@test "pm-render: label video and depth pictures" {
  render --labels videos/labels.mp4 --inventory inventory.json --depth depth
  [ "$(stat -c %s videos/labels.mp4)" -gt 1000 ]
  [ "$(ls depth | wc -l)" -eq 10 ]
  # 16 bits, grey, per the PNG header; the record says what a level is.
  [ "$(od -An -tu1 -j24 -N2 depth/depth_0000.png | tr -s ' ')" = " 16 0" ]
  grep -q '"depth_unit": 0.000' videos/support-stiff.json
  fails_with 3 render --labels videos/labels.mp4 --inventory "$root/tests/data/stages/inventory.json" -- "state.h5"
}

@test "pm-render: floor and signs are in the pictures alone, and nothing that is measured knows of them" {
  render --png plain
  measured() { python3 -c "import json; r = json.load(open('videos/support-stiff.json')); print(r['frames'], r.get('endpoints'))"; }
  before=$(measured)
  render --png floor --floor shadow --threads 1
  [ "$(measured)" = "$before" ]
  refute cmp -s plain/frame_0005.png floor/frame_0005.png
  before_bytes=$(fingerprint floor)
  render --png floor --floor shadow --threads 3
  [ "$(fingerprint floor)" = "$before_bytes" ]
  "$bin/pm-scene" slice --scene bundle/scene.json --out spec --set render.agents=true --set render.floor=shadow
  fails_with 2 render --scene spec/render.json -- "--candidate"
  fails_with 3 render --scene spec/render.json --candidate candidates/posterior.json -- "/id" "support-stiff"
  render --scene spec/render.json --candidate candidates/support-stiff.json --png signs
  [ "$(measured)" = "$before" ]
  # Without a floor in its specification, a slice does not say where the floor is.
  "$bin/pm-scene" slice --scene bundle/scene.json --out spec
  fails_with 3 render --scene spec/render.json --floor shadow -- "/run/colliders"
  refute grep -q colliders spec/render.json
}

@test "pm-render fit: a camera for several rollouts; measurements stay in the scene's own" {
  # This one spreads.
  "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/hard-support-bonded.json --out r.h5
  render() { "$bin/pm-render" --scene bundle/scene.json --state state.h5 --rollout r.h5 --out v.mp4 "$@"; }
  picture() { "$bin/pm-render" --scene spec/render.json --state state.h5 --rollout r.h5 --out v.mp4 "$@"; }
  # A camera that sees the scene at its right edge: what spreads there is outside.
  python3 - <<'PY'
import json
scene = json.load(open("bundle/scene.json"))
scene["output_cameras"][0]["cx"] += 50
json.dump(scene, open("bundle/scene.json", "w"))
PY
  render
  inside() { # whether all frames show everything
    python3 - <<'PY'
import json, sys
r = json.load(open("v.json"))
sys.exit(any(min(f["box"]) <= 0 or max(f["box"]) >= r["width"] for f in r["frames"]))
PY
  }
  refute inside
  measured() { python3 -c "import json; r = json.load(open('v.json')); print(r.get('endpoints') or [r['frames'][0], r['frames'][-1]])"; }
  before=$(measured)
  "$bin/pm-scene" slice --scene bundle/scene.json --out spec --set render.camera=fit
  fit() { "$bin/pm-render" fit --scene spec/render.json --state state.h5 --rollout r.h5 --out cameras/round0.json "$@"; }
  fit --threads 1
  grep -q '"candidates": \[' cameras/round0.json
  cp cameras/round0.json first.json
  fit --threads 3
  cmp cameras/round0.json first.json
  picture --cameras cameras/round0.json
  [ "$(measured)" = "$before" ]
  grep -q '"cameras/round0.json\|round0.json"' v.json
  inside
  # By hand the camera is fitted on the way; a second round keeps what the first one saw.
  picture
  inside
  [ "$(measured)" = "$before" ]
  fit --widen first.json --out wider.json
  diff <(python3 -c "import json; print(json.load(open('first.json'))['cameras'])") <(python3 -c "import json; print(json.load(open('wider.json'))['cameras'])")
  "$bin/pm-scene" slice --scene bundle/scene.json --out spec --set render.camera=orbit
  fit
  [ "$(grep -c world_to_camera cameras/round0.json)" -eq 10 ]
  picture --cameras cameras/round0.json
  [ "$(measured)" = "$before" ]
  fails_with 2 "$bin/pm-render" fit --scene spec/render.json --state state.h5 --out c.json -- "--rollout"
}

@test "pm-render compare: videos side by side with titles" {
  render
  render --out videos/short.mp4 --frames 0-4
  "$bin/pm-render" compare videos/support-stiff.mp4 videos/short.mp4 --title "stiff" --title "cut short" --out compare.mp4
  [ "$(stat -c %s compare.mp4)" -gt 1000 ]
  before=$(fingerprint compare.mp4)
  "$bin/pm-render" compare videos/support-stiff.mp4 videos/short.mp4 --title "stiff" --title "cut short" --out compare.mp4
  [ "$(fingerprint compare.mp4)" = "$before" ]
  fails_with 2 "$bin/pm-render" compare videos/short.mp4 --out compare.mp4 -- "2 to 64"
  fails_with 2 "$bin/pm-render" compare videos/short.mp4 videos/short.mp4 --title one --out compare.mp4 -- "--title"
  fails_with 2 "$bin/pm-render" compare videos/short.mp4 videos/short.mp4 -- "--out"
  fails_with 3 "$bin/pm-render" compare videos/short.mp4 missing.mp4 --out compare.mp4 -- "missing.mp4"
  fails_with 3 "$bin/pm-render" compare videos/short.mp4 state.h5 --out compare.mp4 -- "state.h5"
}

@test "pm-render: equal input gives the same video whatever the thread count, and keeps the timestamp" {
  render --threads 1
  before=$(stat -c %y videos/support-stiff.mp4)
  sleep 0.05
  render --threads 3
  [ "$(stat -c %y videos/support-stiff.mp4)" = "$before" ]
}

@test "pm-render: --frames renders those frames only, and says so" {
  render --frames 0,3-4 --png png
  ls png | grep -q frame_0003.png
  [ "$(ls png | wc -l)" -eq 3 ]
  grep -q '"frames_written": 3' videos/support-stiff.json
  grep -q '"--frames asks for 0,3-4"' videos/support-stiff.json
}

@test "pm-render: what stands still is not projected again, and the record says so" {
  render --frames 3,3
  grep -q '"projection of what stood still"' videos/support-stiff.json
  count=$("$bin/pm-scene" info bundle/gaussians.ply | grep -oE '[0-9]+ Gaussians' | head -1 | cut -d' ' -f1)
  grep -q "\"$count of $((2 * count)) Gaussians over all frames" videos/support-stiff.json
}

@test "pm-render: a diverged rollout has a record and no video, and an old video and its frames go" {
  render --png png
  edit candidates/support-stiff.json 's/"E": [0-9.e+]+/"E": 3e11/'
  simulate --quiet
  render --png png
  [ ! -e videos/support-stiff.mp4 ]
  [ -z "$(ls png)" ]
  grep -q '"video": null' videos/support-stiff.json
  grep -q 'diverged' videos/support-stiff.json
}

@test "pm-render: bad input" {
  fails_with 3 render --rollout missing.h5 -- "missing.h5"
  head -c 2000 rollouts/support-stiff.h5 >rollouts/cut.h5
  fails_with 3 render --rollout rollouts/cut.h5 -- "cut.json"
  cp rollouts/support-stiff.json rollouts/cut.json
  fails_with 3 render --rollout rollouts/cut.h5 -- "cut.json" "/provenance/outputs" "cut.h5"
  # Beside a record of an earlier version, which names no rollout.
  python3 -c 'import json; d = json.load(open("rollouts/cut.json")); del d["provenance"]["outputs"]; json.dump(d, open("rollouts/cut.json", "w"))'
  cp rollouts/cut.json state.json
  fails_with 3 render --rollout rollouts/cut.h5 -- "cut.h5"
  fails_with 3 render --rollout state.h5 -- "/@schema"
  rm rollouts/support-stiff.json
  fails_with 3 render -- "support-stiff.json"
}

@test "pm-render: Gaussians that are not those of the state" {
  "$bin/pm-scene" synth "$root/examples/pineapple.json" --out other
  fails_with 3 render --scene other/scene.json -- "state.h5" "/gaussians/row"
}
