// The deterministic compiler of a plan that an agent proposed action by action (paper, Appendix "Generalized
// Object-Part Scene Agent Prompt"): resolves rows, canonicalises the fields, validates.
#ifndef PHYSMAS_PLAN_ACTION_PROPOSAL_H
#define PHYSMAS_PLAN_ACTION_PROPOSAL_H

#include <string>

#include "plan/scene_geometry.h"
#include "records/inventory.h"
#include "records/plan.h"
#include "records/run_specification.h"

namespace physmas::plan {

// proposal: fits schemas/scene_reply.json; its `actions` become the plan's, itself the plan's proposal. References are
// ids and keys, or a name that fits exactly one of them. Directions (words, axes, vectors, "toward ID") become unit
// vectors in scene axes, magnitudes are bounded by the table in records/actions.h, intervals end with the run; every
// change stands in `corrections`. Errors (exit code 4) name the action and field, what was found, and the candidates or
// forms that were expected.
Plan compile_proposal(const Json& proposal, const std::string& prompt, const Inventory& inventory,
                      const SceneGeometry& geometry, const RunSpecification& run);

}  // namespace physmas::plan

#endif
