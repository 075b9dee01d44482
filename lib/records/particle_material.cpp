#include "records/particle_material.h"

#include <algorithm>
#include <limits>

namespace physmas {

ParticleNumbers MaterialDomain::clamped(const ParticleNumbers& numbers) const {
  return {std::clamp(numbers.E, E_lo, E_hi), std::clamp(numbers.nu, nu_lo, nu_hi),
          std::clamp(numbers.rho, rho_lo, rho_hi)};
}

MaterialDomain material_domain(int label) {
  const LabelPrior& prior = kLabels[label];
  return {prior.E_lo,
          prior.E_hi,
          std::clamp(prior.nu_lo, kSolverNu[0], kSolverNu[1]),
          std::clamp(prior.nu_hi, kSolverNu[0], kSolverNu[1]),
          kSolverRho[0],
          kSolverRho[1]};
}

ParticleNumbers particle_numbers(const CandidateRow& row, const ParticleField& field, size_t q) {
  const ParticleNumbers own = {row.E, row.nu, row.rho};
  if (!row.field || !field.has_sample(q)) return own;
  const ParticleNumbers sample = material_domain(row.field->label).clamped({field.E[q], field.nu[q], field.rho[q]});
  const ParticleNumbers& reference = row.field->numbers;
  MaterialDomain domain = material_domain(row.label);
  constexpr double kAny = std::numeric_limits<double>::infinity();
  if (own.E < domain.E_lo || own.E > domain.E_hi) domain.E_lo = 0, domain.E_hi = kAny;
  if (own.rho < domain.rho_lo || own.rho > domain.rho_hi) domain.rho_lo = 0, domain.rho_hi = kAny;
  // No solid has 0.5.
  if (own.nu < domain.nu_lo || own.nu > domain.nu_hi)
    domain.nu_lo = std::min(own.nu, kSolverNu[0]), domain.nu_hi = std::max(own.nu, kSolverNu[1]);
  return domain.clamped(
      {own.E * (sample.E / reference.E), own.nu + (sample.nu - reference.nu), own.rho * (sample.rho / reference.rho)});
}

bool has_own_materials(const Candidate& candidate, const ParticleField& field) {
  return !field.empty() && std::any_of(candidate.rows.begin(), candidate.rows.end(),
                                       [](const CandidateRow& row) { return row.field.has_value(); });
}

}  // namespace physmas
