#!/usr/bin/env bats
# pm-render's files for other programs, read by those programs where they can be had (make test-python), and by our own
# importer; every value is compared with the 3DGS files of the same frames, which plain Python reads.

bats_require_minimum_version 1.5.0

load tiny

setup_file() {
  make_tiny_run
  cd "$BATS_FILE_TMPDIR/run" || return 1
  render --ply ply --npz motion.npz --usd motion.usdc --compressed-ply compressed --spz spz --glb frame.glb --frame 4 --threads 2
}

setup() { cd "$BATS_FILE_TMPDIR/run" || return 1; }

python=${PM_PYTHON:-$root/build/test/python/bin/python}

# needs PACKAGE...: of other people; without them the test is skipped.
needs() {
  "$python" -c "import importlib, sys; [importlib.import_module(name) for name in sys.argv[1:]]" "$@" 2>/dev/null ||
    skip "$python lacks $*: make test-python installs them"
}

# with_others ARGUMENTS: of exported.py.
with_others() {
  "$python" "$root/tests/cli/exported.py" "$@"
}

@test "pm-render: options for other programs are checked" {
  fails_with 2 render --usd motion.usda -- ".usdc"
  fails_with 2 render --npz motion.txt -- ".npz"
  fails_with 2 render --frame 3 -- "--glb"
  fails_with 2 render --glb a.glb --frame 10 -- "--frame" "below 10"
  fails_with 2 render --usd a.usdc --frames 3,1 -- "--frames" "ascend"
  [ ! -e a.glb ]
}

@test "exports: the arrays of the .npz are the frames' values" {
  python3 "$root/tests/cli/exported.py" npz motion.npz ply
  cp motion.npz again.npz
  render --npz again.npz --frames 2,5-6 --threads 1
  python3 "$root/tests/cli/exported.py" npz again.npz ply
}

@test "exports: the .glb is the frame, with y up" {
  python3 "$root/tests/cli/exported.py" glb frame.glb ply/frame_0004.ply
}

@test "exports: files do not depend on threads, and unchanged ones are not written again" {
  before=$(fingerprint compressed spz motion.npz motion.usdc frame.glb)
  render --npz motion.npz --usd motion.usdc --compressed-ply compressed --spz spz --glb frame.glb --frame 4 --threads 1
  [ "$(fingerprint compressed spz motion.npz motion.usdc frame.glb)" = "$before" ]
}

@test "exports: quantised files look like the frame when they are imported" {
  [ "$(ls compressed | wc -l)" -eq 10 ]
  [ "$(ls spz | wc -l)" -eq 10 ]
  local file
  for file in "ply/frame_0007.ply z" "compressed/frame_0007.compressed.ply z" "spz/frame_0007.spz y"; do
    "$bin/pm-scene" import "${file% *}" --up "${file#* }" --prompt "it falls" --out "again/${file%%/*}"
  done
  for view in front right back left; do
    for kind in compressed spz; do
      python3 "$root/tests/cli/foreign_files.py" psnr again/ply/views/$view.png again/$kind/views/$view.png 32
    done
  done
}

@test "exports: OpenUSD reads every value of every frame" {
  needs pxr
  with_others usd motion.usdc ply
  # And what it shows is the frame.
  with_others usd-ply motion.usdc 7 usd.ply
  "$bin/pm-scene" import ply/frame_0007.ply --up z --prompt "it falls" --out again/frame
  "$bin/pm-scene" import usd.ply --up z --prompt "it falls" --out again/usd
  for view in front right back left; do
    python3 "$root/tests/cli/foreign_files.py" psnr again/frame/views/$view.png again/usd/views/$view.png 40
  done
}

@test "exports: plyfile and gsply read the frames" {
  needs gsply plyfile numpy
  with_others splats ply compressed spz
}

@test "exports: the ten lines of Python in the documentation run" {
  needs numpy
  sed -n '/^```python/,/^```/p' "$root/docs/motion-files.md" | grep -v '^```' >lines.py
  [ "$(wc -l <lines.py)" -le 12 ]
  "$python" lines.py | grep -q "10 frames"
}
