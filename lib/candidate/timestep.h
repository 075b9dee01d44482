// The heterogeneous step-size rule (paper, Eqs. supp-wavespeed and supp-adaptivedt).
#ifndef PHYSMAS_CANDIDATE_TIMESTEP_H
#define PHYSMAS_CANDIDATE_TIMESTEP_H

#include <vector>

#include "records/candidate.h"
#include "records/evidence.h"
#include "records/run_specification.h"

namespace physmas::candidate {

// The target step, its ceiling-rounded count of substeps per output frame, and the caps. The whole-object row always
// takes part.
TimestepResult step_size(const std::vector<CandidateRow>& rows, const WholeObject& whole,
                         const RunSpecification::Time& time);

}  // namespace physmas::candidate

#endif
