// The state in which a run begins.
#ifndef PHYSMAS_BIND_START_H
#define PHYSMAS_BIND_START_H

#include <optional>
#include <string>
#include <vector>

#include "mpm/equilibrium.h"
#include "records/execution.h"
#include "records/run_specification.h"

namespace physmas::bind {

// With time.start: equilibrium, gives the problem's particles the deformation that carries their weight; otherwise
// nothing is computed or changed. `device` does not decide the result.
std::optional<mpm::Equilibrium> bind_start(const RunSpecification::Time& time, const Device& device,
                                           mpm::Problem& problem);

// row_keys: of the problem's materials.
StartRecord start_record(const mpm::Equilibrium& equilibrium, const std::vector<std::string>& row_keys);

}  // namespace physmas::bind

#endif
