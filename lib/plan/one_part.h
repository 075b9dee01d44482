// The study without object-part state (paper, "Ablation Study"): every object becomes one part.
#ifndef PHYSMAS_PLAN_ONE_PART_H
#define PHYSMAS_PLAN_ONE_PART_H

#include <vector>

#include "records/inventory.h"
#include "records/masks.h"
#include "records/plan.h"

namespace physmas::plan {

// Replaces the semantic rows of every object by one row "OBJECT/whole" with the object's name and role and the labels
// that its parts expected; residual rows stay. Its mask is the object's, or the union of its parts' where a view has no
// mask of the object. Plan references to parts become references to their objects, which `plan.corrections` says.
void collapse_parts(Inventory& inventory, std::vector<ViewMasks>& views, Plan& plan);

}  // namespace physmas::plan

#endif
