// What became of a simulation, as its execution record.
#ifndef PHYSMAS_BIND_EXECUTION_H
#define PHYSMAS_BIND_EXECUTION_H

#include <string>

#include "bind/timing.h"
#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/execution.h"

namespace physmas::bind {

// The record of `candidate` simulated as `problem`. Measures that overflowed are written as 0; the error token says
// why.
ExecutionRecord execution_record(const Candidate& candidate, const mpm::Problem& problem, const BoundTiming& timing,
                                 const mpm::Options& options, const mpm::Result& result);

// The record of a candidate that diverged and was simulated once more: the second one's where that is stable, else the
// first one's. Either names both attempts. allowed: substeps.
ExecutionRecord with_retry(const ExecutionRecord& first, long long first_allowed, const ExecutionRecord& second,
                           long long second_allowed);

}  // namespace physmas::bind

#endif
