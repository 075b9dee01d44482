// Numbers of an action that follow from the words alone, or from where the masks say that things are.
#ifndef PHYSMAS_PLAN_ACTION_VALUES_H
#define PHYSMAS_PLAN_ACTION_VALUES_H

#include <string>
#include <vector>

#include "plan/prompt.h"
#include "plan/scene_geometry.h"
#include "records/plan.h"

namespace physmas::plan {

// Sum of the directions that the event says; zero when it says none or they cancel out. Scene axes.
Eigen::Vector3d said_direction(const Event& event, const SceneGeometry& geometry);

// Unit direction of an action that does not move something somewhere (down for presses and holds, up for a spread, the
// axis of torque and scale, inwards for side_compress); zero for the others.
Eigen::Vector3d own_direction(const Event& event, ActionType type, const SceneGeometry& geometry);

// The default of the action under the event's strength, or the speed it says; not bounded yet.
double wanted_magnitude(const Event& event, ActionType type);

// `wanted` within the action's bounds; what was changed is added to `corrections`. A support_hold has none.
double bounded_magnitude(ActionType type, double wanted, std::vector<std::string>& corrections);

// How long a mover is driven [s]: over the free gap and a part of the target's depth; `otherwise` where the masks do
// not tell.
double contact_time(const PlanAction& action, const SceneGeometry& geometry, double otherwise);

}  // namespace physmas::plan

#endif
