// What a particle of a row is made of, given a sample of a material field.
#include "records/particle_material.h"

#include <doctest/doctest.h>

using namespace physmas;

namespace {

// Particle 0 is at the row's numbers in the field, 1 above, 2 below, 3 outside every domain, 4 without a sample.
ParticleField field() {
  ParticleField field;
  field.E = {1e6f, 4e6f, 5e5f, 1e14f, 0};
  field.nu = {0.25f, 0.375f, 0.1875f, 0.5f, 0};
  field.rho = {1000, 2000, 500, 1e6f, 0};
  return field;
}

CandidateRow row(double E, double nu, double rho, int label = kPlasticine) {
  CandidateRow row;
  row.E = E, row.nu = nu, row.rho = rho, row.label = label;
  row.field = {{1e6, 0.25, 1000}, kPlasticine};
  return row;
}

void check(const ParticleNumbers& n, double E, double nu, double rho) {
  CHECK(n.E == doctest::Approx(E));
  CHECK(n.nu == doctest::Approx(nu));
  CHECK(n.rho == doctest::Approx(rho));
}

}  // namespace

TEST_CASE("particle material: a row at its field's numbers gives every particle its sample, in the row's domain") {
  const CandidateRow same = row(1e6, 0.25, 1000);
  check(particle_numbers(same, field(), 0), 1e6, 0.25, 1000);
  check(particle_numbers(same, field(), 1), 4e6, 0.375, 2000);
  // Plasticine's nu goes from 0.25.
  check(particle_numbers(same, field(), 2), 5e5, 0.25, 500);
  check(particle_numbers(same, field(), 3), 1e7, 0.45, 3000);
  check(particle_numbers(same, field(), 4), 1e6, 0.25, 1000);
}

TEST_CASE("particle material: what a candidate changes of a row changes all its particles alike") {
  const CandidateRow soft = row(5e5, 0.3, 1500);
  check(particle_numbers(soft, field(), 1), 2e6, 0.425, 3000);
  check(particle_numbers(soft, field(), 2), 2.5e5, 0.3, 750);
  // E beyond the domain is the candidate's own word: the ratios stay. nu stays below 0.5.
  check(particle_numbers(row(1e8, 0.485, 5000), field(), 1), 4e8, 0.485, 1e4);
  check(particle_numbers(row(1e8, 0.485, 5000), field(), 3), 1e9, 0.485, 1.5e4);
  // Another label than the field's: its domain for the particle, the field's for the sample.
  check(particle_numbers(row(1e6, 0.25, 1000, kFoam), field(), 3), 1e7, 0.45, 3000);
}

TEST_CASE("particle material: rows without a field have one material") {
  CandidateRow plain = row(7, 0.1, 9);
  plain.field.reset();
  check(particle_numbers(plain, field(), 1), 7, 0.1, 9);
  Candidate candidate;
  candidate.rows = {plain};
  CHECK_FALSE(has_own_materials(candidate, field()));
  candidate.rows.push_back(row(1, 0.3, 1));
  CHECK(has_own_materials(candidate, field()));
  CHECK_FALSE(has_own_materials(candidate, {}));
}

TEST_CASE("particle material: the domain is the label's and the solver's") {
  const MaterialDomain rubber = material_domain(kRubber), metal = material_domain(kMetal);
  CHECK(rubber.nu_lo == 0.4);
  CHECK(rubber.nu_hi == 0.45);
  CHECK(metal.E_lo == 1e9);
  CHECK(metal.rho_hi == 3000);
}
