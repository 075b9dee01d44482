# What is read and written: regular files only, whole or not at all, within the machine's limits, and nothing that leaves a
# tool makes a terminal do more than print.
load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

@test "files: a pipe is neither read nor replaced" {
  mkfifo in out.h5
  fails_with 3 timeout 20 "$bin/pm-simulate" --scene in --state state.h5 --candidate candidates/soft.json --out r.h5 -- "in: found a pipe"
  fails_with 3 timeout 20 "$bin/pm-simulate" --scene bundle/scene.json --state in --candidate candidates/soft.json --out r.h5 -- "in: found a pipe"
  fails_with 3 timeout 20 "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/soft.json --out out.h5 -- "out.h5: found a pipe"
  fails_with 3 timeout 20 "$bin/pm-scene" info in -- "in: found a pipe"
  mkfifo in.ply
  fails_with 3 timeout 20 "$bin/pm-scene" info in.ply -- "in.ply: found a pipe"
  [ -p out.h5 ]
}

@test "files: a device is neither read nor replaced" {
  # A node of this test's own, with the numbers of /dev/null.
  mknod node.h5 c 1 3 2>mknod.log || skip "only root may make a device"
  fails_with 3 "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/soft.json --out node.h5 -- "node.h5: found a device"
  fails_with 3 "$bin/pm-simulate" --scene bundle/scene.json --state node.h5 --candidate candidates/soft.json --out r.h5 -- "node.h5: found a device"
  [ -c node.h5 ]
}

@test "files: an HDF5 file on which the library crashes is refused" {
  cp "$root/tests/data/damaged-state.h5" damaged.h5
  fails_with 3 "$bin/pm-simulate" --scene bundle/scene.json --state damaged.h5 --candidate candidates/soft.json --out r.h5 -- "damaged.h5: " "expected"
  [ ! -e r.h5 ]
}

@test "files: a link that leaves the bundle is refused" {
  mv bundle/gaussians.ply outside.ply
  ln -s ../outside.ply bundle/gaussians.ply
  fails_with 3 "$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out z.h5 -- "scene.json: /gaussians" "a link that leaves the bundle"
}

@test "files: a limit of the size of files is an error, not a signal" {
  # Not 0: what the error is printed to is a file as well.
  for blocks in 1 8; do
    limited() (ulimit -f "$blocks"; "$@")
    fails_with 3 limited "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/soft.json --out r.h5 -- "r.h5: cannot be written"
    [ ! -e r.h5 ]
  done
  limited() (ulimit -f 1; "$@")
  fails_with 3 limited "$bin/pm-render" --scene bundle/scene.json --state state.h5 --rollout rollouts/support-stiff.h5 --out v.mp4 -- "v.mp4: cannot be written"
  fails_with 3 limited "$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out z.h5 -- "z.h5: cannot be written"
  fails_with 3 limited "$bin/pm-material" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out e.json -- "e.json: cannot be written: File too large"
}

@test "files: what a killed process left is swept by the next one into that folder" {
  "$bin/pm-simulate" --scene bundle/scene.json --state state.h5 --candidate candidates/soft.json --out rollouts/soft.h5 &
  until half=$(compgen -G 'rollouts/.soft.h5.*.tmp') || ! kill -0 $!; do :; done
  kill -KILL $!
  wait $! || true
  [ -n "$half" ] || skip "the simulation was faster"
  [ -e "$half" ]
  simulate
  [ ! -e "$half" ]
}

@test "files: no thread and no memory are errors of the machine" {
  limited() (ulimit -v 60000; "$@")
  [ "${PM_SAN:-0}" = 0 ] || skip "sanitizers need memory"
  for threads in 1 64; do
    status=0
    limited "$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out z.h5 --threads "$threads" 2>log || status=$?
    cat log
    # Where not even the libraries can be loaded, the loader says so.
    [ "$status" -eq 3 ] || [ "$status" -eq 127 ]
    [ "$(wc -l <log)" -eq 1 ]
  done
  limited() (ulimit -v 900000; "$@")
  fails_with 3 limited "$bin/pm-lift" --scene bundle/scene.json --inventory inventory.json --masks masks.h5 --out z.h5 --threads 1024 -- "--threads"
}

@test "files: a full standard output is an error" {
  full() { "$@" >/dev/full; }
  for command in "pm-scene info bundle/scene.json" "pm-scene info bundle/gaussians.ply" "pm-scene --help" "pm-lift --version" "pm-screen --advice"; do
    status=0
    full "$bin"/$command 2>log || status=$?
    cat log
    [ "$status" -eq 3 ]
    grep -q 'error: standard output: cannot be written: No space left on device' log
  done
  # A reader that has seen enough is none.
  "$bin/pm-scene" info bundle/gaussians.ply | true
  [ "${PIPESTATUS[0]}" -eq 0 ]
}

@test "files: no control character reaches the terminal" {
  python3 - <<'PY'
import json
scene = json.load(open('bundle/scene.json'))
scene['prompt'] = 'it falls \u001b[31m\u009b31m \u202e \u2066 \u2028\nand more'
json.dump(scene, open('bundle/scene.json', 'w'))
PY
  "$bin/pm-scene" info bundle/scene.json >out
  "$bin/pm-scene" info $'bundle/\e[31m\u009b.ply' 2>err || true
  cat err
  python3 - <<'PY'
for name in ('out', 'err'):
    text = open(name, encoding='utf-8', newline='').read()
    bad = [hex(ord(c)) for c in text if (ord(c) < 32 and c not in '\n\t') or 0x7f <= ord(c) < 0xa0 or c in '\u202e\u2066\u2028']
    assert not bad and text, (name, bad)
PY
  [ "$(grep -c prompt out)" -eq 1 ]
  refute grep -q '^and more' out
}

@test "files: a picture that libpng grumbles about is read without a line of its" {
  python3 - <<'PY'
import struct, zlib
data = open('bundle/views/front.png', 'rb').read()
def chunk(kind, body):
    return struct.pack('>I', len(body)) + kind + body + struct.pack('>I', zlib.crc32(kind + body))
# A colour profile that is none, after IHDR.
at = 8 + 25
open('bundle/views/front.png', 'wb').write(data[:at] + chunk(b'iCCP', b'x\0\0' + zlib.compress(b'no profile')) + data[at:])
PY
  "$bin/pm-ground" --scene bundle/scene.json --out . 2>err
  cat err
  refute grep -v '^pm-ground: ' err
}
