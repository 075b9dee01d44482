#!/usr/bin/env bats
bats_require_minimum_version 1.5.0
load stages

setup() { make_scene; }

@test "pm-material: help goes to stdout" {
  run --separate-stderr "$bin/pm-material" --help
  [ "$status" -eq 0 ]
  [[ $output == *"--predictor"* ]]
  [ -z "$stderr" ]
}

@test "pm-material: usage errors" {
  fails_with 2 "$bin/pm-material" -- "--scene is required"
  fails_with 2 material --agent nobody -- "--agent nobody" "expected builtin, a URL, or replay:DIR"
  fails_with 2 material --predictor ftp://localhost/v2/models/m -- "--predictor" "scheme \"ftp\""
  [ ! -e evidence.json ]
}

@test "pm-material: built-in evidence from schema and roles, residual rows last" {
  material
  grep -q '"key": "cake/residual"' evidence.json
  # The plate: schema 0.125 + role 0.055 for Ceramic over 0.34 in all.
  grep -q '"Ceramic": 0.18,' evidence.json
  grep -q 'expected label \\"Velvet\\" of cake/icing' evidence.json
  grep -q '"what": "crop and vision-language evidence"' evidence.json
}

@test "pm-material: predictor records enter the posterior, the moments and the whole-object record" {
  material --predictor material-records.json
  grep -q '"mean": 4.127251' evidence.json
  grep -q '"source": "authored"' evidence.json
  grep -q '"probability": 0.5879120879120879' evidence.json
}

@test "pm-material: a rerun keeps bytes and timestamp" {
  material
  touch -d '2001-01-01' evidence.json
  material
  [ "$(date -r evidence.json +%Y)" = 2001 ]
}

@test "pm-material: files that are missing, malformed or of another schema" {
  rm masks.h5
  fails_with 3 material -- masks.h5 "No such file"
  make_scene
  echo '{"schema": "physmas/inventory/1", ' >inventory.json
  fails_with 3 material -- inventory.json "malformed JSON" "line"
  make_scene
  cp plan.json inventory.json
  fails_with 3 material -- inventory.json /schema physmas/plan/1 physmas/inventory/1
  make_scene
  sed -i 's/"name": "Plate"/"name": "Plate", "colour": 1/' inventory.json
  fails_with 3 material -- inventory.json /rows/0 colour
  [ ! -e evidence.json ]
}

@test "pm-material: duplicate rows and a state or masks of another inventory" {
  sed -i 's/"part": "sponge"/"part": "plate"/' inventory.json
  fails_with 3 material -- inventory.json /rows/1/part plate
  make_scene
  sed -i 's/"part": "sponge"/"part": "biscuit"/' inventory.json
  fails_with 3 material -- masks.h5 cake/sponge
  "$make_fixture" masks inventory.json masks.h5 0.9
  fails_with 3 material -- state.h5 "rows of the inventory"
  [ ! -e evidence.json ]
}

@test "pm-material: truncated HDF5 files" {
  truncate -s 3000 state.h5
  fails_with 3 material -- state.h5
  make_scene
  truncate -s 3000 masks.h5
  fails_with 3 material -- masks.h5
  [ ! -e evidence.json ]
}

@test "pm-material: predictor records that do not fit" {
  records() { sed "$1" "$data/material-records.json" >records.json; }
  records 's/"Rubber"/"Jade"/'
  fails_with 3 material --predictor records.json -- records.json /rows/0/crops/1/evidence Jade
  records 's/cake\/sponge/cake\/biscuit/'
  fails_with 3 material --predictor records.json -- records.json /rows/0/key cake/biscuit
  records 's/"E": 200000.0/"E": 0/'
  fails_with 3 material --predictor records.json -- records.json /whole_object/crops/0/E
  records 's/"E": 200000.0/"E": NaN/'
  fails_with 3 material --predictor records.json -- records.json "malformed JSON"
  records 's/"E": 200000.0/"E": 200000.0, "E_mean": 0.5/'
  fails_with 3 material --predictor records.json -- records.json /whole_object/crops/0
  fails_with 3 material --predictor nowhere.json -- nowhere.json "No such file"
  [ ! -e evidence.json ]
}

@test "pm-material: authored records come ahead of the predictor's, and all of them are kept" {
  cat >authored.json <<'J'
{"schema": "physmas/material_records/1", "rows": [{"key": "cake/sponge", "crops": [{"E": 30000, "E_uncertainty": 0.2, "nu": 0.25, "evidence": {"Foam": 1}}]}],
 "whole_object": {"label": "Foam"}}
J
  material --predictor material-records.json --authored authored.json
  python3 - <<'PY'
import json
evidence = json.load(open("evidence.json"))
sponge = next(r for r in evidence["rows"] if r["key"] == "cake/sponge")
assert [c.get("E") for c in sponge["observations"]["crops"]] == [30000, None, None] and sponge["E"]["records"] == 3
# The mean of three crops now: 0.35 x (1 + 0.6 + 0.4) / 3.
assert abs(sponge["sources"]["crop"]["Foam"] - 0.35 * 2 / 3) < 1e-12
assert evidence["whole_object"]["label"] == "Foam"
PY
  fails_with 3 material --authored nowhere.json -- nowhere.json "No such file"
}

@test "pm-material: an output that cannot be written" {
  mkdir evidence.json
  fails_with 3 material -- evidence.json "a folder"
}
