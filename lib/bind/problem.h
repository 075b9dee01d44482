// A candidate and the records that it acts in, as the solver's problem (paper, "Solver-Aware Shared-Domain
// Simulation": Bind).
#ifndef PHYSMAS_BIND_PROBLEM_H
#define PHYSMAS_BIND_PROBLEM_H

#include <string>

#include "mpm/simulation.h"
#include "records/candidate.h"
#include "records/run_specification.h"
#include "records/state.h"

namespace physmas::bind {

// All particles of the state at rest, in its order.
mpm::Particles bind_particles(const State& state);

// Where the records came from, for errors.
struct ProblemFiles {
  std::string state, candidate;
};

// Domain, materials, constants, particles and schedule. Throws an Error (exit code 3) when the state was made for a
// cube of another size than the run's, and as bind_materials.
mpm::Problem bind_problem(const Candidate& candidate, const State& state, const RunSpecification& run,
                          const ProblemFiles& files);

}  // namespace physmas::bind

#endif
