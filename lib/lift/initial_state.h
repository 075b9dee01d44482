// The paper's Z^0 from labels: particles, their sources and rest volumes.
#ifndef PHYSMAS_LIFT_INITIAL_STATE_H
#define PHYSMAS_LIFT_INITIAL_STATE_H

#include <string>

#include "lift/assignment.h"
#include "records/inventory.h"
#include "records/run_specification.h"
#include "records/state.h"
#include "scene/gaussians.h"

namespace physmas::lift {

// The first N_G particles are the Gaussian means under N, or, of more Gaussians than particles.max, those of the
// carriers (carriers.h); filled ones follow and take source and row from the nearest
// Gaussian of their object (paper, Eqs. particlesource and particlearray; lowest index on ties). What was not filled,
// and where the density had to give way to the limit, stands in `omitted`.
// file: the Gaussians' file, for messages. Error (exit code 3): fewer carriers than rows.
State initial_state(const Gaussians& gaussians, const Labels& labels, const Inventory& inventory,
                    const RunSpecification& run, const std::string& file);

}  // namespace physmas::lift

#endif
