load tiny

setup_file() { make_tiny_run; }
setup() { enter_tiny_run; }

@test "pm-render: help and usage" {
  shows_help pm-render
  fails_with 2 "$bin/pm-render" -- "--scene"
  fails_with 2 render --frames 0-10 -- "--frames" "below 10"
  fails_with 2 render --frames x -- "--frames"
  fails_with 2 render --ply frames -- "not built yet"
  fails_with 2 render --out video.avi -- ".mp4"
}

@test "pm-render: a video with every frame, a record, frames as PNG" {
  render --png png
  grep -q '"frames_written": 10' videos/support-stiff.json
  [ "$(ls png | wc -l)" -eq 10 ]
  [ "$(head -c 8 png/frame_0005.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]
  [ "$(stat -c %s videos/support-stiff.mp4)" -gt 1000 ]
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

@test "pm-render: a diverged rollout has a record and no video, and an old video goes" {
  render
  edit candidates/support-stiff.json 's/"E": [0-9.e+]+/"E": 3e11/'
  simulate --quiet
  render
  [ ! -e videos/support-stiff.mp4 ]
  grep -q '"video": null' videos/support-stiff.json
  grep -q 'diverged' videos/support-stiff.json
}

@test "pm-render: bad input" {
  fails_with 3 render --rollout missing.h5 -- "missing.h5"
  head -c 2000 rollouts/support-stiff.h5 >rollouts/cut.h5
  fails_with 3 render --rollout rollouts/cut.h5 -- "cut.h5"
  fails_with 3 render --rollout state.h5 -- "/@schema"
  rm rollouts/support-stiff.json
  fails_with 3 render -- "support-stiff.json"
}

@test "pm-render: Gaussians that are not those of the state" {
  "$bin/pm-scene" synth "$root/examples/pineapple.json" --out other
  fails_with 3 render --scene other/scene.json -- "state.h5" "/gaussians/row"
}
