#include "plan/scene_inventory.h"

#include <algorithm>

#include "base/words.h"
#include "plan/prompt.h"
#include "records/json.h"

namespace physmas::plan {

Inventory inventory_from_prompt(const std::string& prompt) {
  const Reading reading = read_prompt(prompt, {});
  const std::string name = reading.first_noun.empty() ? "object" : join(reading.first_noun, " ");
  InventoryObject object;
  object.id = identifier_of(name);
  object.name = name;
  object.scene_role = "subject";
  InventoryRow row;
  row.object = object.id;
  row.part = object.id == kResidualPart ? "object" : object.id;
  row.name = name;
  Inventory inventory;
  inventory.objects.push_back(object);
  inventory.rows.push_back(row);
  return inventory;
}

void complete_inventory(Inventory& inventory, const std::vector<std::string>& view_names, const std::string& file) {
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (!inventory.rows[r].residual && inventory.rows[r].part == kResidualPart) {
      throw invalid_field(file, "/rows/" + std::to_string(r) + "/part", inventory.rows[r].part,
                          "another part id: residual is kept for the residual row");
    }
  }
  std::vector<InventoryRow> residual;
  for (InventoryObject& object : inventory.objects) {
    const auto of_object = [&](const InventoryRow& row) { return row.object == object.id; };
    const auto authored = std::find_if(inventory.rows.begin(), inventory.rows.end(),
                                       [&](const InventoryRow& row) { return of_object(row) && row.residual; });
    if (std::none_of(inventory.rows.begin(), inventory.rows.end(),
                     [&](const InventoryRow& row) { return of_object(row) && !row.residual; })) {
      throw invalid_input({file, "/rows", "no semantic row of object \"" + object.id + "\"", "at least one"});
    }
    InventoryRow row;
    row.object = object.id;
    row.part = kResidualPart;
    row.name = kResidualPart;
    row.residual = true;
    residual.push_back(authored == inventory.rows.end() ? row : *authored);
    if (object.queries.empty()) {
      for (const std::string& view : view_names) object.queries.push_back({view, object.name});
    }
  }
  inventory.rows.erase(std::remove_if(inventory.rows.begin(), inventory.rows.end(),
                                      [](const InventoryRow& row) { return row.residual; }),
                       inventory.rows.end());
  inventory.rows.insert(inventory.rows.end(), residual.begin(), residual.end());
}

std::vector<std::string> nouns_of(const Inventory& inventory) {
  std::vector<std::string> nouns;
  const auto add = [&](const std::string& name) {
    for (const std::string& word : name_words(name)) nouns.push_back(word);
  };
  for (const InventoryObject& object : inventory.objects) {
    add(object.id);
    add(object.name);
  }
  for (const InventoryRow& row : inventory.rows) {
    if (row.residual) continue;
    add(row.part);
    add(row.name);
  }
  return nouns;
}

}  // namespace physmas::plan
