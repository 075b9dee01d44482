// What perception looks for: one text per object and semantic row, in the views that show it.
#ifndef PHYSMAS_GROUND_QUERIES_H
#define PHYSMAS_GROUND_QUERIES_H

#include <map>
#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/masks.h"

namespace physmas::ground {

struct Query {
  std::string text;
  std::vector<std::string> views;
};
using Queries = std::map<std::string, Query>;  // by object id and row key; absent: not looked for

// The inventory's own texts: an object's queries, else its name; a row's name.
Queries queries_of(const Inventory& inventory, const std::vector<std::string>& view_names);

// Second attempts name what the first missed together with its object ("cake icing"). Only `keys` are in the result.
Queries wider_queries(const Inventory& inventory, const std::vector<std::string>& view_names,
                      const std::vector<std::string>& keys);

// Object ids and semantic row keys without a mask in any view, in inventory order.
std::vector<std::string> without_support(const Inventory& inventory, const std::vector<ViewMasks>& views);

}  // namespace physmas::ground

#endif
