#include "records/known_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "records/json.h"
#include "records/labels.h"

namespace physmas {

void require_known_names(const Inventory& inventory, const std::vector<std::string>& views, const std::string& file) {
  const auto require_view = [&](const std::string& view, const std::string& field) {
    if (std::find(views.begin(), views.end(), view) == views.end())
      throw invalid_field(file, field, view, fmt::format("a view of the scene: {}", fmt::join(views, ", ")));
  };
  const auto require_regions = [&](const AppearanceHints& hints, const std::string& field) {
    for (const auto& [view, polygons] : hints.regions) require_view(view, field + "/hints/regions");
  };
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    const std::string field = fmt::format("/objects/{}", o);
    const std::vector<InventoryObject::Query>& queries = inventory.objects[o].queries;
    for (size_t q = 0; q < queries.size(); ++q)
      require_view(queries[q].view, fmt::format("{}/queries/{}/view", field, q));
    require_regions(inventory.objects[o].hints, field);
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const std::string field = fmt::format("/rows/{}", r);
    require_regions(inventory.rows[r].hints, field);
    const std::vector<std::string>& labels = inventory.rows[r].expected_labels;
    for (size_t l = 0; l < labels.size(); ++l) {
      if (find_label(labels[l])) continue;
      std::vector<std::string> known;
      for (const LabelPrior& label : kLabels) known.push_back(label.name);
      throw invalid_field(file, fmt::format("{}/expected_labels/{}", field, l), labels[l],
                          fmt::format("one of {}", fmt::join(known, ", ")));
    }
  }
}

}  // namespace physmas
