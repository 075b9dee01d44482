// A plan that somebody wrote or changed, in place of what the prompt gives.
#ifndef PHYSMAS_PLAN_AUTHORED_PLAN_H
#define PHYSMAS_PLAN_AUTHORED_PLAN_H

#include <string>

#include "records/inventory.h"
#include "records/plan.h"

namespace physmas::plan {

// The actions, materials and stillness of the record `path`, as they stand, for a scene with this prompt, which
// `corrections` says. Errors (exit code 3) as load_plan has them.
Plan authored_plan(const std::string& path, const std::string& prompt, const Inventory& inventory);

}  // namespace physmas::plan

#endif
