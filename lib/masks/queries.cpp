#include "masks/queries.h"

#include <algorithm>

namespace physmas::masks {

Queries queries_of(const Inventory& inventory, const std::vector<std::string>& view_names) {
  Queries queries;
  for (const InventoryObject& object : inventory.objects) {
    Query& query = queries[object.id];
    query.text = object.queries.empty() ? object.name : object.queries[0].text;
    for (const InventoryObject::Query& q : object.queries) query.views.push_back(q.view);
    if (object.queries.empty()) query.views = view_names;
  }
  for (const InventoryRow& row : inventory.rows) {
    if (!row.residual) queries[row.key()] = {row.name, view_names};
  }
  return queries;
}

Queries wider_queries(const Inventory& inventory, const std::vector<std::string>& view_names,
                      const std::vector<std::string>& keys) {
  Queries queries;
  for (const std::string& key : keys) {
    if (const int o = inventory.find_object(key); o >= 0) {
      queries[key] = {inventory.objects[o].name, view_names};
    } else if (const int r = inventory.find_row(key); r >= 0) {
      queries[key] = {inventory.objects[inventory.object_of_row(r)].name + " " + inventory.rows[r].name, view_names};
    }
  }
  return queries;
}

std::vector<std::string> without_support(const Inventory& inventory, const std::vector<ViewMasks>& views) {
  std::vector<std::string> missed;
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    if (std::all_of(views.begin(), views.end(), [&](const ViewMasks& v) { return v.objects[o].empty(); }))
      missed.push_back(inventory.objects[o].id);
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (inventory.rows[r].residual) continue;
    if (std::all_of(views.begin(), views.end(), [&](const ViewMasks& v) { return v.rows[r].empty(); }))
      missed.push_back(inventory.rows[r].key());
  }
  return missed;
}

}  // namespace physmas::masks
