// What became of a simulation, as its execution record.
#ifndef PHYSMAS_BIND_EXECUTION_H
#define PHYSMAS_BIND_EXECUTION_H

#include <string>

#include "bind/timing.h"
#include "mpm/simulation.h"
#include "records/execution.h"

namespace physmas::bind {

// The record of `candidate` simulated as `problem`. Measures that overflowed are written as 0; the error token says
// why.
ExecutionRecord execution_record(const std::string& candidate, const mpm::Problem& problem, const BoundTiming& timing,
                                 const mpm::Options& options, const mpm::Result& result);

}  // namespace physmas::bind

#endif
