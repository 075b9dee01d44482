# Runs of a tiny scene with a coarse grid, as a user of installed tools makes them.

# Not $(MAKE) of the tests' own make, and no build.
run_make() {
  env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make --no-print-directory -f "$root/pipelines/installed.mk" BIN="$bin" "$@"
}

# bundle and spec.json in the current folder.
make_coarse_scene() {
  "$bin/pm-scene" synth "$root/tests/data/tiny.json" --out bundle --quiet
  cat >spec.json <<'J'
{"schema": "physmas/run/1", "grid": {"n": 24}, "time": {"frames": 4, "substep_dt": 8e-4, "min_substep_dt": 2e-4, "max_substeps": 200},
 "screening": {"initial": 2, "rounds": 1, "tau": -9}, "render": {"width": 64, "height": 64}}
J
}
