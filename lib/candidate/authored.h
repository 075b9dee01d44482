// A candidate from a hand-authored configuration: its rows and actions as they stand, without controls.
#ifndef PHYSMAS_CANDIDATE_AUTHORED_H
#define PHYSMAS_CANDIDATE_AUTHORED_H

#include <string>
#include <vector>

#include "records/candidate.h"
#include "records/configuration.h"
#include "records/run_specification.h"

namespace physmas::candidate {

// No domain clamps the values: they are the author's. Residual rows with Gaussians, which nobody can author, are unit
// Plastic. The step is the paper's rule; pm-simulate --timestep may choose another.
// gaussians: how many carry each row, [inventory.rows]. file: for messages about actions.
Candidate authored_candidate(const AuthoredConfiguration& configuration, const Inventory& inventory,
                             const RunSpecification& run, const std::vector<long>& gaussians, const std::string& file);

}  // namespace physmas::candidate

#endif
