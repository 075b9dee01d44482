// From one action of the plan to one operation of the schedule.
#ifndef PHYSMAS_CANDIDATE_COMPILE_ACTION_H
#define PHYSMAS_CANDIDATE_COMPILE_ACTION_H

#include <string>

#include "candidate/context.h"

namespace physmas::candidate {

// The operation of `action` without its steps: region, velocity or ratio, and the fixed numbers of its kind
// (docs/actions.md). The interval is cut at the run's end, an impulse at four base substeps. Throws an Error
// (exit code 3) when no active row is meant, or when a ratio is not possible. plan_file, pointer: for messages.
ScheduleOperation compile_action(const Context& context, const PlanAction& action, const std::string& plan_file,
                                 const std::string& pointer);

}  // namespace physmas::candidate

#endif
