// The built-in agent's inventory: the authored one, or one object from the prompt's noun; with its residual rows.
#ifndef PHYSMAS_PLAN_SCENE_INVENTORY_H
#define PHYSMAS_PLAN_SCENE_INVENTORY_H

#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas::plan {

constexpr const char* kResidualPart = "residual";

// One object with one part, named after what the prompt acts on; after the scene where it names nothing that a scene
// holds (agents, tools, "it").
Inventory inventory_from_prompt(const std::string& prompt, const std::string& scene_name);

// Puts one residual row per object behind all semantic rows, in object order (paper, "Object-Part Scene Agent":
// residual rows complete the cover), and a query per object and view where the author gave none.
// file: the inventory's file, for messages. Throws (exit code 3) when an object has no semantic row or a semantic row
// takes the residual part's id.
void complete_inventory(Inventory& inventory, const std::vector<std::string>& view_names, const std::string& file);

// Words (singular) of all names and ids, for read_prompt().
std::vector<std::string> nouns_of(const Inventory& inventory);

}  // namespace physmas::plan

#endif
