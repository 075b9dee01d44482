// What perception looks for, and what it missed.
#ifndef PHYSMAS_MASKS_QUERIES_H
#define PHYSMAS_MASKS_QUERIES_H

#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/masks.h"
#include "records/queries.h"

namespace physmas::masks {

// The inventory's own texts: an object's queries, else its name; a row's name.
Queries queries_of(const Inventory& inventory, const std::vector<std::string>& view_names);

// Second attempts name what the first missed together with its object ("cake icing"). Only `keys` are in the result.
Queries wider_queries(const Inventory& inventory, const std::vector<std::string>& view_names,
                      const std::vector<std::string>& keys);

// Object ids and semantic row keys without a mask in any view, in inventory order.
std::vector<std::string> without_support(const Inventory& inventory, const std::vector<ViewMasks>& views);

}  // namespace physmas::masks

#endif
