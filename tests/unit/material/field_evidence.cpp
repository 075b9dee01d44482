// What a material field says of rows.
#include "material/field_evidence.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace physmas;

namespace {

Evidence evidence() {
  Evidence evidence;
  evidence.rows.resize(3);
  for (EvidenceRow& row : evidence.rows) row.label = kPlasticine, row.log10_E = 5, row.nu = 0.37, row.key = "a/x";
  return evidence;
}

// Row 0: four particles with samples and one without; row 1: none with a sample; row 2: no particle.
State state() {
  State state;
  state.row = {0, 0, 0, 0, 0, 1};
  state.field.E = {2e6f, 1e6f, 4e6f, 1e9f, 0, 0};
  state.field.nu = {0.3f, 0.1f, 0.4f, 0.48f, 0, 0};
  state.field.rho = {1000, 500, 2000, 20000, 0, 0};
  return state;
}

}  // namespace

TEST_CASE("field evidence: rows take the median of what lies in their domain, and count") {
  Evidence e = evidence();
  material::take_field(e, state());
  REQUIRE(e.rows[0].field);
  const EvidenceRow::Field& f = *e.rows[0].field;
  CHECK(f.particles == 5);
  CHECK(f.sampled == 4);
  CHECK(f.E.least == 1e6);
  CHECK(f.E.median == 4e6);
  CHECK(f.E.most == 1e7);
  CHECK(f.E.clamped == 1);
  CHECK(f.nu.least == 0.25);
  CHECK(f.nu.most == 0.45);
  CHECK(f.nu.clamped == 2);
  CHECK(f.rho.most == 3000);
  CHECK(f.rho.clamped == 1);
  CHECK(e.rows[0].log10_E == std::log10(4e6));
  CHECK(e.rows[0].nu == f.nu.median);
  CHECK(e.rows[0].label == kPlasticine);
  for (const int r : {1, 2}) {
    CHECK_FALSE(e.rows[r].field);
    CHECK(e.rows[r].log10_E == 5);
  }
}

TEST_CASE("field evidence: a line says the share, the range, and what to do where much was clamped") {
  Evidence e = evidence();
  material::take_field(e, state());
  CHECK(material::field_line(e.rows[0]) ==
        "a/x: the material field has 80 % of its particles, E 1e+06 to 1e+07 Pa, median 4e+06; E of 25 % of them was "
        "outside the 1e+03 to 1e+07 Pa of Plasticine and taken at its end: --material (MATERIAL=) says what it is made "
        "of");
  e.rows[0].field->E.clamped = 0;
  CHECK(material::field_line(e.rows[0]).find("outside") == std::string::npos);
}

TEST_CASE("field evidence: a state without a field changes nothing") {
  Evidence e = evidence();
  State plain = state();
  plain.field = {};
  material::take_field(e, plain);
  CHECK_FALSE(e.rows[0].field);
  CHECK(e.rows[0].log10_E == 5);
}
