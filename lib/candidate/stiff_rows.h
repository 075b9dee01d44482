// Whether the rows that an action turns are too stiff for a bounded force.
#ifndef PHYSMAS_CANDIDATE_STIFF_ROWS_H
#define PHYSMAS_CANDIDATE_STIFF_ROWS_H

#include <vector>

#include "candidate/context.h"

namespace physmas::candidate {

// Whether what a torque turns is held by more than its own inertia: it is a slab, or its object has further active
// rows.
bool is_attached(const Context& context, const ScheduleOperation& torque);

// Whether a blend leaves an attached torque short of the angle that it asks for. A slab of thickness h that is drawn to
// the speed ω r over the blend time τ pulls with the traction ρ h ω r / τ; a twist by ω T over the length l needs
// G ω T r / l. So the force reaches no farther than the wave speed c² = G/ρ = h l / (τ T); h l is at most 0.2 × 0.6 of
// the scene's extent squared. c is the largest among the active rows of the objects that are turned.
// rows: of the candidate.
bool resists_blending(const Context& context, const std::vector<CandidateRow>& rows, const ScheduleOperation& torque);

}  // namespace physmas::candidate

#endif
