// Changes to a run specification from the command line.
#ifndef PHYSMAS_RECORDS_OVERRIDES_H
#define PHYSMAS_RECORDS_OVERRIDES_H

#include <string>
#include <vector>

#include "records/json_fwd.h"

namespace physmas {

// One run object from a run specification file (empty: none) and settings "KEY=VALUE" on top, later ones winning.
// KEY: fields joined by dots ("screening.tau"); VALUE: JSON, or else taken as text ("z"). Errors: exit code 3 from the
// file, exit code 2 for a setting without a key or that no run specification can have.
Json run_overrides(const std::string& file, const std::vector<std::string>& settings);

}  // namespace physmas

#endif
