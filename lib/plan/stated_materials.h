// Materials that the user states: in the prompt ("a rubber bear"), or outright with --material.
#ifndef PHYSMAS_PLAN_STATED_MATERIALS_H
#define PHYSMAS_PLAN_STATED_MATERIALS_H

#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/plan.h"

namespace physmas::plan {

// text: "head=Rubber body=Wood", or "Rubber" for everything; labels are those of the paper's Table "visual labels",
// without case; things are ids, keys or names of the inventory. Error (exit code 2): another label or thing, with those
// there are.
std::vector<PlanMaterial> stated_materials(const std::string& text, const Inventory& inventory);

// What is stated replaces the expected labels of those rows; several labels for one row are all expected. Residual
// rows, which nobody can describe, stay.
void expect_materials(const std::vector<PlanMaterial>& materials, Inventory& inventory);

}  // namespace physmas::plan

#endif
