// From a candidate's rows and the run's profile constants to what the solver knows of materials.
#ifndef PHYSMAS_BIND_MATERIALS_H
#define PHYSMAS_BIND_MATERIALS_H

#include <string>
#include <vector>

#include "mpm/material/material.h"
#include "records/candidate.h"
#include "records/run_specification.h"
#include "records/state.h"

namespace physmas::bind {

// The paper's Bind: the record Theta_r of every row of the state, [state.row_keys], whatever the candidate's order.
// Rows without particles may be missing from the candidate. file: the candidate's, for errors. Throws an Error (exit
// code 3) when a row's index and key do not meet in the state, or when a row with particles is missing.
std::vector<mpm::Material> bind_materials(const Candidate& candidate, const State& state, const std::string& file);

// The material of every particle, [N_Q], where a material field gives the candidate's particles numbers of their own;
// else none. materials: as bind_materials returns them.
std::vector<mpm::Material> bind_particle_materials(const Candidate& candidate, const State& state,
                                                   const std::vector<mpm::Material>& materials);

mpm::ProfileConstants bind_constants(const RunSpecification::Profile& profile);

}  // namespace physmas::bind

#endif
