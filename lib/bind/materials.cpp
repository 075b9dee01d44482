#include "bind/materials.h"

#include <fmt/format.h>

#include "base/error.h"
#include "bind/branch.h"
#include "records/json.h"
#include "records/particle_material.h"

namespace physmas::bind {

std::vector<mpm::Material> bind_materials(const Candidate& candidate, const State& state, const std::string& file) {
  std::vector<mpm::Material> materials(state.row_keys.size());
  std::vector<bool> bound(state.row_keys.size(), false);
  for (size_t i = 0; i < candidate.rows.size(); ++i) {
    const CandidateRow& row = candidate.rows[i];
    if (row.row >= static_cast<int>(state.row_keys.size()) || state.row_keys[row.row] != row.key) {
      throw invalid_field(file, fmt::format("/rows/{}/key", i), row.key,
                          fmt::format("the key of row {} of the state", row.row),
                          "make the candidates again with pm-candidates");
    }
    materials[row.row] = {bind_branch(row.branch), row.E, row.nu, row.rho};
    bound[row.row] = true;
  }
  for (const int32_t r : state.row) {
    if (!bound[r])
      throw invalid_input(
          {file, "/rows", "no row \"" + state.row_keys[r] + "\"", "every row that has particles in the state"});
  }
  return materials;
}

std::vector<mpm::Material> bind_particle_materials(const Candidate& candidate, const State& state,
                                                   const std::vector<mpm::Material>& materials) {
  if (!has_own_materials(candidate, state.field)) return {};
  std::vector<const CandidateRow*> row_of(state.row_keys.size(), nullptr);
  for (const CandidateRow& row : candidate.rows) row_of[row.row] = &row;
  std::vector<mpm::Material> own(state.particle_count());
  for (size_t q = 0; q < own.size(); ++q) {
    const ParticleNumbers numbers = particle_numbers(*row_of[state.row[q]], state.field, q);
    own[q] = {materials[state.row[q]].branch, numbers.E, numbers.nu, numbers.rho};
  }
  return own;
}

mpm::ProfileConstants bind_constants(const RunSpecification::Profile& profile) {
  mpm::ProfileConstants constants;
  constants.foam_yield = profile.foam_yield;
  constants.foam_viscosity = profile.foam_viscosity;
  constants.plasticine_yield = profile.plasticine_yield;
  constants.plasticine_softening = profile.plasticine_softening;
  constants.plasticine_residual = profile.plasticine_residual;
  constants.sand_friction_angle = profile.sand_friction_angle;
  constants.drucker_prager_alpha = profile.alpha;
  constants.sand_cohesion = profile.sand_k;
  constants.snow_cohesion = profile.snow_k;
  constants.plasticine_cohesion = profile.plasticine_k;
  return constants;
}

}  // namespace physmas::bind
