#include "records/reference.h"

#include <algorithm>
#include <set>

#include "base/words.h"

namespace physmas {
namespace {

using Words = std::set<std::string>;

Words words_of(const std::string& name, const std::string& id) {
  Words words;
  for (const std::string& text : {name, id}) {
    for (const std::string& word : name_words(text)) words.insert(word);
  }
  return words;
}

// The noun that a name is about: its last word before a preposition ("glass of beverage" is a glass).
std::string head_of(const std::string& name) {
  std::string head;
  for (const std::string& word : name_words(name)) {
    if (word == "on" || word == "of" || word == "with" || word == "in" || word == "at" || word == "for" ||
        word == "from" || word == "under") {
      break;
    }
    head = word;
  }
  return head;
}

bool has_head(const std::string& name, const std::string& id, const std::string& head) {
  return head_of(name) == head || head_of(id) == head;
}

}  // namespace

std::vector<std::string> find_references(const Inventory& inventory, const NounPhrase& phrase) {
  if (phrase.empty()) return {};
  std::vector<std::string> spoken;
  for (const std::string& word : phrase) spoken.push_back(singular(word));
  const auto count = [&](const Words& words) {
    return std::count_if(spoken.begin(), spoken.end(), [&](const std::string& w) { return words.count(w) > 0; });
  };
  std::vector<std::string> best;
  long best_count = 0;
  const auto offer = [&](const std::string& reference, long fitting) {
    if (fitting < best_count) return;
    if (fitting > best_count) best.clear();
    best_count = fitting;
    best.push_back(reference);
  };
  for (const InventoryObject& object : inventory.objects) {
    if (has_head(object.name, object.id, spoken.back())) offer(object.id, count(words_of(object.name, object.id)));
  }
  const size_t objects = best.size();
  const long object_count = best_count;
  for (const InventoryRow& row : inventory.rows) {
    if (row.residual || !has_head(row.name, row.part, spoken.back())) continue;
    const InventoryObject& owner = inventory.objects[inventory.find_object(row.object)];
    Words words = words_of(row.name, row.part);
    const Words owner_words = words_of(owner.name, owner.id);
    words.insert(owner_words.begin(), owner_words.end());
    const long fitting = count(words);
    if (objects == 0 || fitting > object_count) offer(row.key(), fitting);
  }
  return best;
}

std::vector<std::string> find_group(const Inventory& inventory, const NounPhrase& phrase) {
  if (phrase.empty() || !find_references(inventory, phrase).empty()) return {};
  const std::string head = singular(phrase.back());
  std::vector<std::string> group;
  for (const InventoryRow& row : inventory.rows) {
    if (row.residual || words_of(row.name, row.part).count(head) == 0) continue;
    if (!group.empty() && object_of(group[0]) != row.object) return {};
    group.push_back(row.key());
  }
  return group;
}

std::vector<std::string> all_references(const Inventory& inventory) {
  std::vector<std::string> all;
  for (const InventoryObject& object : inventory.objects) all.push_back(object.id);
  for (const InventoryRow& row : inventory.rows) {
    if (!row.residual) all.push_back(row.key());
  }
  return all;
}

std::string object_of(const std::string& reference) {
  return reference.substr(0, reference.find('/'));
}

}  // namespace physmas
