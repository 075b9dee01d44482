# Shared by the tests of pm-material, pm-candidates and pm-screen: a small cake scene made with build/test/make_fixture.
load common
# Fixtures come from the same build as the tools.
make_fixture=${PM_TEST_BIN:-$bin/../test}/make_fixture
data=$root/tests/data/stages

# A working folder with copies of the JSON fixtures, masks.h5 and state.h5 (3, 4, 2 and 1 Gaussians per row).
make_scene() {
  cd "$BATS_TEST_TMPDIR" || return 1
  cp "$data"/*.json .
  "$make_fixture" masks inventory.json masks.h5 0.9
  "$make_fixture" state inventory.json state.h5 3 4 2 1
}

material() { "$bin/pm-material" --scene scene.json --inventory inventory.json --masks masks.h5 --state state.h5 --out evidence.json "$@"; }
candidates() { "$bin/pm-candidates" --scene scene.json --inventory inventory.json --plan plan.json --evidence evidence.json --state state.h5 --out candidates "$@"; }

