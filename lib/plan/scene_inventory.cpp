#include "plan/scene_inventory.h"

#include <algorithm>

#include "base/words.h"
#include "plan/prompt.h"
#include "records/json.h"

namespace physmas::plan {

namespace {

// A phrase as a name, without what it is made of; empty where it names nothing that a scene could hold.
std::string name_in(const NounPhrase& phrase, bool or_tool_or_ground) {
  if (phrase.empty() || is_pronoun(phrase.front())) return "";
  const std::string head = singular(phrase.back());
  if (is_external(head) || means_whole(head)) return "";
  if (!or_tool_or_ground && (is_tool(head) || is_ground(head))) return "";
  std::vector<std::string> words;
  for (size_t i = 0; i < phrase.size(); ++i) {
    if (i + 1 == phrase.size() || !find_material(phrase[i])) words.push_back(phrase[i]);
  }
  return join(words, " ");
}

// What the prompt is about: the thing that it introduces, else what is acted on first, else what it mentions.
std::string name_of(const Reading& reading) {
  if (reading.events.empty()) return "";
  for (const bool wide : {false, true}) {
    std::string name = name_in(reading.opening_noun, false);
    for (const Event& event : reading.events) {
      for (const NounPhrase& phrase : {event.passive ? event.subject : event.object, event.subject, event.goal}) {
        if (name.empty()) name = name_in(phrase, wide);
      }
    }
    if (name.empty()) name = name_in(reading.first_noun, wide);
    if (!name.empty()) return name;
  }
  return "";
}

}  // namespace

Inventory inventory_from_prompt(const std::string& prompt, const std::string& scene_name) {
  std::string name = name_of(read_prompt(prompt, {}));
  if (name.empty()) name = scene_name.empty() ? "object" : scene_name;
  InventoryObject object;
  object.id = identifier_of(name);
  object.name = name;
  object.scene_role = "subject";
  InventoryRow row;
  row.object = object.id;
  row.part = object.id == kResidualPart ? "object" : object.id;
  row.name = name;
  row.named_by_prompt = true;
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
