#!/usr/bin/env bats
bats_require_minimum_version 1.5.0
load stages

setup() {
  make_scene
  material --predictor material-records.json
}

@test "pm-candidates: help goes to stdout" {
  run --separate-stderr "$bin/pm-candidates" --help
  [ "$status" -eq 0 ]
  [[ $output == *"--repair"* ]]
  [ -z "$stderr" ]
}

@test "pm-candidates: usage errors" {
  fails_with 2 "$bin/pm-candidates" --scene scene.json -- "is required"
  fails_with 2 candidates --rounds 3 -- "--rounds"
}

@test "pm-candidates: round 0 with its makefile line" {
  candidates
  [ "$(cat candidates/round0.mk)" = "PM_ROUND0 := posterior target-impact hard-support-bonded support-stiff solver-compatible rigid-support" ]
  grep -q '"what": "soft"' candidates/round0.json
  [ "$(ls candidates/*.json | wc -l)" -eq 7 ]
  # Sponge of the posterior: 10^4.12725116 Pa.
  grep -q '"E": 13404.51669' candidates/posterior.json
  # The predictor's whole-object record: Plasticine, 2e5 Pa, nu 0.45, rho 2000; the plate takes 1.6 times that.
  grep -q '"E": 320000.0' candidates/solver-compatible.json
  printf 'include candidates/round0.mk\nall:; @echo $(words $(PM_ROUND0))\n' >check.mk
  [ "$(make -s -f check.mk)" -eq 6 ]
}

@test "pm-candidates: a rerun keeps bytes and timestamps, files of earlier runs stay" {
  candidates
  echo keep >candidates/other.json
  touch -d '2001-01-01' candidates/*
  candidates
  for f in candidates/*; do [ "$(date -r "$f" +%Y)" = 2001 ]; done
}

@test "pm-candidates: a residual row without Gaussians is left out, and two objects never bond" {
  cp inventory-two-objects.json inventory.json
  "$make_fixture" masks inventory.json masks.h5 0.9
  "$make_fixture" state inventory.json state.h5 3 4 2 3 2 0
  material
  candidates
  grep -q '"what": "row cake/residual"' candidates/posterior.json
  refute grep '"key": "cake/residual"' candidates/posterior.json
  grep -q '"retention": \[\]' candidates/hard-support-bonded.json
  grep -q '"cake/plate": 0.85' candidates/hard-support-bonded.json
}

@test "pm-candidates: bad files" {
  rm evidence.json
  fails_with 3 candidates -- evidence.json "No such file"
  material
  sed -i 's/"mask_confidence"/"mask_trust"/' evidence.json
  fails_with 3 candidates -- evidence.json /rows/0 mask_trust
  make_scene; material
  sed -i 's/"target": "cake"/"target": "pie"/' plan.json
  fails_with 3 candidates -- plan.json /actions/0/target pie
  echo '{]' >plan.json
  fails_with 3 candidates -- plan.json "malformed JSON"
  cp "$data/plan.json" .
  truncate -s 2000 state.h5
  fails_with 3 candidates -- state.h5
  [ ! -e candidates ]
}

@test "pm-candidates: evidence that contradicts itself" {
  edit_evidence() {
    material --predictor material-records.json
    sed -i -E "$1" evidence.json
  }
  edit_evidence 's/"log10": 4\.127[0-9]*/"log10": 12/'
  fails_with 3 candidates -- evidence.json /rows/1/E/log10 "found 12.0" "domain of Foam"
  edit_evidence 's/"log10": 4\.127[0-9]*/"log10": NaN/'
  fails_with 3 candidates -- evidence.json "malformed JSON"
  edit_evidence 's/"value": 0\.3092[0-9]*/"value": 0.49/'
  fails_with 3 candidates -- evidence.json /rows/1/nu/value "domain of Foam"
  edit_evidence 's/"probability": 0\.0769[0-9]*/"probability": 0.5/'
  fails_with 3 candidates -- evidence.json /rows/1/posterior/2/probability "descending"
  edit_evidence 's/"probability": 0\.0769[0-9]*/"probability": 0.05/'
  fails_with 3 candidates -- evidence.json /rows/1/posterior "sum to 1"
  edit_evidence 's/"label": "Foam",/"label": "Jade",/'
  fails_with 3 candidates -- evidence.json /rows Jade
  edit_evidence 's/"rho": 2000.0/"rho": 0/'
  fails_with 3 candidates -- evidence.json /whole_object/rho
  [ ! -e candidates ]
}

@test "pm-candidates: an interval that ends before it starts" {
  sed -i 's/"start": 0.0/"start": 0.5/' plan.json
  fails_with 3 candidates -- plan.json /actions/0/end "0.04"
}

@test "pm-candidates: evidence of another inventory, row or state" {
  sed -i 's/"key": "cake\/icing"/"key": "cake\/glaze"/' evidence.json
  fails_with 3 candidates -- evidence.json /rows/2/key cake/glaze cake/icing
  material
  old=$(sha256sum <state.h5 | cut -d' ' -f1)
  "$make_fixture" state inventory.json state.h5 9 4 2 1
  new=$(sha256sum <state.h5 | cut -d' ' -f1)
  fails_with 3 candidates -- evidence.json /provenance/inputs "$old" "$new"
  [ ! -e candidates ]
}

@test "pm-candidates: every action of the vocabulary compiles, impossible ratios are refused" {
  material
  for action in translation top_press radial_spread vertical_compress side_compress drag_pair scale torque support_hold; do
    sed "s/\"type\": \"impulse\"/\"type\": \"$action\"/; s/\"magnitude\": 2.0/\"magnitude\": 0.8/" "$data/plan.json" >plan.json
    candidates
    grep -q "\"operation\": \"$action\"" candidates/posterior.json
  done
  rm -r candidates
  sed 's/"type": "impulse"/"type": "side_compress"/' "$data/plan.json" >plan.json
  fails_with 3 candidates -- plan.json /actions/0/magnitude 2 "at most 1"
  [ ! -e candidates ]
}

@test "pm-candidates: a budget from the run specification" {
  sed -i 's/"frames": 3/"frames": 3}, "screening": {"initial": 2/' scene.json
  material
  candidates
  [ "$(cat candidates/round0.mk)" = "PM_ROUND0 := posterior target-impact" ]
}

@test "pm-candidates: the row followed by hand in docs/method.md" {
  sed -i 's/"frames": 3/"frames": 3}, "screening": {"initial": 10/' scene.json
  material --predictor material-records.json
  candidates
  sponge() { # ID BRANCH E NU RHO
    grep -A5 '"key": "cake/sponge"' "candidates/$1.json" >row.txt
    grep -q "\"branch\": \"$2\"" row.txt
    grep -q "\"E\": $3" row.txt
    grep -q "\"nu\": $4" row.txt
    grep -q "\"rho\": $5" row.txt
  }
  sponge posterior Foam 13404.516 0.3092 300
  sponge target-impact Foam 20000.0 0.3092 300
  sponge hard-support-bonded Plasticine 200000.0 0.45 2000
  sponge support-stiff Foam 13404.516 0.3092 300
  sponge solver-compatible Plasticine 200000.0 0.45 2000
  sponge rigid-support Foam 7966.502 0.3427 300
  sponge soft Foam 7966.502 0.3427 300
  sponge stiff Foam 22554.574 0.3092 300
  sponge uncertainty-sweep Foam 13404.516 0.3427 300
  sponge alternative-material Foam 13404.516 0.3092 300
  grep -A6 '"key": "cake/icing"' candidates/alternative-material.json | grep -q '"label": "Foam"'
}
