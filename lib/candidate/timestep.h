// The heterogeneous step-size rule (paper, Eqs. supp-wavespeed and supp-adaptivedt).
#ifndef PHYSMAS_CANDIDATE_TIMESTEP_H
#define PHYSMAS_CANDIDATE_TIMESTEP_H

#include <vector>

#include "records/candidate.h"
#include "records/evidence.h"
#include "records/run_specification.h"
#include "records/state.h"

namespace physmas::candidate {

// The target step, its ceiling-rounded count of substeps per output frame, and the caps. The whole-object row always
// takes part. state: where its particles have materials of their own, the fastest of them takes part; else null.
// Unless time.stiff is off, what a third of the base step cannot integrate on cells of dx [m] keeps its shape in the
// simulation and asks for no step.
TimestepResult step_size(const std::vector<CandidateRow>& rows, const WholeObject& whole,
                         const RunSpecification::Time& time, double dx, const State* state = nullptr);

}  // namespace physmas::candidate

#endif
