// What a particle is made of where the scene has a material field: its row's branch, and numbers of its own.
#ifndef PHYSMAS_RECORDS_PARTICLE_MATERIAL_H
#define PHYSMAS_RECORDS_PARTICLE_MATERIAL_H

#include <vector>

#include "records/candidate.h"
#include "records/state.h"

namespace physmas {

// Where the numbers of a row's particles may lie: the domain of its label (paper, Table "mapping") and the solver's (nu
// 0.05 to 0.45, rho 300 to 3000).
struct MaterialDomain {
  double E_lo, E_hi, nu_lo, nu_hi, rho_lo, rho_hi;
  ParticleNumbers clamped(const ParticleNumbers& numbers) const;
};
MaterialDomain material_domain(int label);

// Those of particle q, which is in `row`. A row without a field, and a particle without a sample, has the row's. A
// sample counts inside the domain of the field's label, and gives what it has over the row's numbers in the field: E
// and rho by their ratios, nu by the difference, so that what a candidate changes of the row changes every particle
// alike. What is inside the domain of the row's label in the row stays inside it in its particles; a candidate's own
// values win over it, as they do in rows.
ParticleNumbers particle_numbers(const CandidateRow& row, const ParticleField& field, size_t q);

// Whether particles of the candidate have numbers of their own.
bool has_own_materials(const Candidate& candidate, const ParticleField& field);

}  // namespace physmas

#endif
