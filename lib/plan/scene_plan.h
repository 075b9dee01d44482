// The built-in agent's plan: the prompt's events as a proposal, compiled to the canonical plan Pi (paper, "Object-Part
// Scene Agent" and Table "actions").
#ifndef PHYSMAS_PLAN_SCENE_PLAN_H
#define PHYSMAS_PLAN_SCENE_PLAN_H

#include <string>

#include "plan/scene_geometry.h"
#include "records/inventory.h"
#include "records/plan.h"
#include "records/run_specification.h"

namespace physmas::plan {

// How a correction begins that quotes words of the prompt which the agent could not read.
inline constexpr const char* kNotUnderstood = "not understood, left out: ";
inline const std::string kNotDone = "not done: ";

// Resolves the prompt against the inventory. Directions are unit vectors in scene axes; magnitudes are bounded by the
// table in records/actions.h; intervals lie within the run's duration. Everything that was defaulted,
// bounded, left to gravity or not understood is said in `corrections`.
// Errors (exit code 3, field /prompt of `file`): a thing that the inventory does not have or that fits several names;
// they name the verb and the candidates.
Plan plan_from_prompt(const std::string& prompt, const Inventory& inventory, const SceneGeometry& geometry,
                      const RunSpecification& run, const std::string& file);

}  // namespace physmas::plan

#endif
