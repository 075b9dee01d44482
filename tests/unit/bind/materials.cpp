// The paper's Bind: which record Theta_r a particle gets, and what is refused.
#include "bind/materials.h"

#include <doctest/doctest.h>

#include "unit/bind/scenes.h"
#include "unit/input_error.h"

using namespace physmas;

TEST_CASE("bind: rows get their own material, whatever the candidate's order") {
  const std::vector<mpm::Material> materials =
      bind::bind_materials(bind_test::candidate(), bind_test::state(), "c.json");
  REQUIRE(materials.size() == 4);  // one per row of the state, used or not
  const mpm::Material expected[] = {
      {mpm::Branch::metal, 1e7, 0.1, 1100}, {mpm::Branch::foam, 2e4, 0.2, 1200}, {mpm::Branch::sand, 3e5, 0.3, 1300}};
  for (int r = 0; r < 3; ++r) {
    CHECK(materials[r].branch == expected[r].branch);
    CHECK(materials[r].E == expected[r].E);
    CHECK(materials[r].nu == expected[r].nu);
    CHECK(materials[r].rho == expected[r].rho);
  }
}

TEST_CASE("bind: a candidate that does not belong to the state is refused") {
  const State state = bind_test::state();
  const auto refusal = [&](const Candidate& candidate) {
    return message_of([&] { bind::bind_materials(candidate, state, "c.json"); });
  };
  Candidate candidate = bind_test::candidate();
  candidate.rows[1].key = "a/z";  // another key at row 0
  CHECK(refusal(candidate) ==
        "c.json: /rows/1/key: found \"a/z\", expected the key of row 0 of the state; make the candidates again with "
        "pm-candidates");
  candidate = bind_test::candidate();
  candidate.rows[0].row = 1;  // the index of another row
  CHECK(refusal(candidate).find("/rows/0/key: found \"b/x\", expected the key of row 1") != std::string::npos);
  candidate = bind_test::candidate();
  candidate.rows[2].row = 4;  // past the end
  CHECK(refusal(candidate).find("/rows/2/key: found \"a/y\", expected the key of row 4") != std::string::npos);
}

TEST_CASE("bind: every row with particles must be in the candidate, and only those") {
  for (const size_t left_out : {0, 1, 2}) {
    Candidate candidate = bind_test::candidate();
    const std::string key = candidate.rows[left_out].key;
    candidate.rows.erase(candidate.rows.begin() + static_cast<long>(left_out));
    CHECK(message_of([&] { bind::bind_materials(candidate, bind_test::state(), "c.json"); }) ==
          "c.json: /rows: found no row \"" + key + "\", expected every row that has particles in the state");
  }
}

TEST_CASE("bind: the solver's constants are the run's, field by field") {
  RunSpecification::Profile profile;
  profile.foam_yield = 1;
  profile.foam_viscosity = 2;
  profile.plasticine_yield = 3;
  profile.plasticine_softening = 4;
  profile.plasticine_residual = 5;
  profile.sand_friction_angle = 6;
  profile.alpha = 7;
  profile.sand_k = 8;
  profile.snow_k = 9;
  profile.plasticine_k = 10;
  const mpm::ProfileConstants constants = bind::bind_constants(profile);
  CHECK(constants.foam_yield == 1);
  CHECK(constants.foam_viscosity == 2);
  CHECK(constants.plasticine_yield == 3);
  CHECK(constants.plasticine_softening == 4);
  CHECK(constants.plasticine_residual == 5);
  CHECK(constants.sand_friction_angle == 6);
  CHECK(constants.drucker_prager_alpha == 7);
  CHECK(constants.sand_cohesion == 8);
  CHECK(constants.snow_cohesion == 9);
  CHECK(constants.plasticine_cohesion == 10);
}

TEST_CASE("bind: particles have materials of their own where a row has a field, with the row's branch") {
  State state = bind_test::state();
  Candidate candidate = bind_test::candidate();
  const std::vector<mpm::Material> rows = bind::bind_materials(candidate, state, "c.json");
  CHECK(bind::bind_particle_materials(candidate, state, rows).empty());
  state.field.E = {8e4f, 6e5f, 0};
  state.field.nu = {0.25f, 0.3f, 0};
  state.field.rho = {600, 2600, 0};
  // A state's field counts where the candidate's rows were made with it.
  CHECK(bind::bind_particle_materials(candidate, state, rows).empty());
  candidate.rows[2].label = kFoam;
  candidate.rows[2].field = {{4e4, 0.2, 1200}, kFoam};
  const std::vector<mpm::Material> own = bind::bind_particle_materials(candidate, state, rows);
  REQUIRE(own.size() == 3);
  CHECK(own[0].branch == mpm::Branch::foam);
  CHECK(own[0].E == doctest::Approx(4e4));
  CHECK(own[0].nu == doctest::Approx(0.25));
  CHECK(own[0].rho == doctest::Approx(600));
  CHECK(own[1].branch == mpm::Branch::sand);
  CHECK(own[1].E == 3e5);
  CHECK(own[2].branch == mpm::Branch::metal);
  CHECK(own[2].rho == 1100);
}
