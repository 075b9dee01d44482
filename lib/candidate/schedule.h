// The schedule compiler: from the plan's actions and a candidate's controls to operations over steps and frames.
#ifndef PHYSMAS_CANDIDATE_SCHEDULE_H
#define PHYSMAS_CANDIDATE_SCHEDULE_H

#include <string>
#include <vector>

#include "candidate/context.h"
#include "candidate/transforms.h"

namespace physmas::candidate {

// Compile(Pi, U_aux) (paper, Eq. materialstate): the plan's actions in plan order, then a structure projection per
// weighted row, then an interface retention per bonded row, both in row order. An action moves its source's rows, or
// its target's when it has none. Throws an Error (exit code 3) for an action without active rows, with an impossible
// ratio or with an empty interval. Actions that start after the run's end are left out and listed in `omitted`.
// plan_file: for messages.
std::vector<ScheduleOperation> compile_schedule(const Context& context, const Configuration& configuration,
                                                const TimestepResult& timestep, const std::string& plan_file,
                                                std::vector<Omission>& omitted);

}  // namespace physmas::candidate

#endif
