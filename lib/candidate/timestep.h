// The heterogeneous step-size rule (paper, Eqs. supp-wavespeed and supp-adaptivedt).
#ifndef PHYSMAS_CANDIDATE_TIMESTEP_H
#define PHYSMAS_CANDIDATE_TIMESTEP_H

#include <vector>

#include "records/candidate.h"
#include "records/evidence.h"
#include "records/run_specification.h"

namespace physmas::candidate {

// Elastic wave-speed proxy sqrt((lambda + 2 G) / rho) [m/s]; E [Pa], rho [kg/m^3].
double wave_speed(double E, double nu, double rho);

// The target step, its ceiling-rounded count of substeps per output frame, and the caps. The whole-object row always
// takes part.
TimestepResult step_size(const std::vector<CandidateRow>& rows, const WholeObject& whole,
                         const RunSpecification::Time& time);

}  // namespace physmas::candidate

#endif
