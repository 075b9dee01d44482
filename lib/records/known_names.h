// Names in an authored inventory that mean something only where they exist.
#ifndef PHYSMAS_RECORDS_KNOWN_NAMES_H
#define PHYSMAS_RECORDS_KNOWN_NAMES_H

#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas {

// Views of queries and of regions must be views of the scene, expected labels among the fourteen (case aside). file:
// the inventory's, for messages. An Error (exit code 3) names the first that is not.
void require_known_names(const Inventory& inventory, const std::vector<std::string>& views, const std::string& file);

}  // namespace physmas

#endif
