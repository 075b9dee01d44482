// Why a simulation diverged, in words for whoever asked for the video.
#ifndef PHYSMAS_BIND_DIVERGENCE_H
#define PHYSMAS_BIND_DIVERGENCE_H

#include "bind/timing.h"
#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/execution.h"

namespace physmas::bind {

// The row to look at, the step that it would have needed and what to set. result: of a diverged run of `problem`.
//
// The substep is to blame where it is longer than the largest stable one of a row at rest, and the row is the one that
// allows the smallest. Otherwise it is the motion: of the row whose particle was the fastest when the fault was found.
Divergence explain_divergence(const Candidate& candidate, const mpm::Problem& problem, const BoundTiming& timing,
                              const mpm::Options& options, const mpm::Result& result);

}  // namespace physmas::bind

#endif
