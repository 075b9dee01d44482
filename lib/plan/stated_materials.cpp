#include "plan/stated_materials.h"

#include <optional>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/words.h"
#include "records/reference.h"

namespace physmas::plan {

void expect_materials(const std::vector<PlanMaterial>& materials, Inventory& inventory) {
  std::set<int> said;
  for (const PlanMaterial& material : materials) {
    for (const int r : resolve_rows(inventory, material.target)) {
      InventoryRow& row = inventory.rows[r];
      if (row.residual) continue;
      if (said.insert(r).second) row.expected_labels.clear();
      row.expected_labels.push_back(kLabels[material.label].name);
    }
  }
}

std::vector<PlanMaterial> stated_materials(const std::string& text, const Inventory& inventory) {
  std::vector<PlanMaterial> materials;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const size_t equals = word.find('=');
    const std::string thing = equals == std::string::npos ? "" : word.substr(0, equals);
    const std::string name = word.substr(equals == std::string::npos ? 0 : equals + 1);
    std::optional<int> label = find_label(name);
    if (!label) {
      std::vector<std::string> labels;
      for (const LabelPrior& known : kLabels) labels.push_back(known.name);
      throw Error(ExitCode::usage,
                  "--material " + one_line(word) + ": expected PART=LABEL or LABEL, one of " + join(labels));
    }
    std::vector<std::string> targets;
    if (thing.empty()) {
      for (const InventoryObject& object : inventory.objects) targets.push_back(object.id);
    } else if (!resolve_rows(inventory, thing).empty()) {
      targets = {thing};
    } else {
      targets = find_references(inventory, name_words(thing));
    }
    if (targets.empty() || (targets.size() > 1 && !thing.empty())) {
      throw Error(ExitCode::usage, "--material " + one_line(word) + ": expected one of " +
                                       join(all_references(inventory)) + " before the =");
    }
    for (const std::string& target : targets) materials.push_back({target, *label, "--material"});
  }
  return materials;
}

}  // namespace physmas::plan
