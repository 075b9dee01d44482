// From a candidate's schedule Gamma to the solver's actions and projections.
#ifndef PHYSMAS_BIND_SCHEDULE_H
#define PHYSMAS_BIND_SCHEDULE_H

#include "mpm/action/schedule.h"
#include "records/candidate.h"
#include "records/run_specification.h"

namespace physmas::bind {

// Operations in their order. A scale becomes two slabs, a drag_pair its puller and, when something follows, a follower.
mpm::Schedule bind_schedule(const Candidate& candidate, const RunSpecification& run);

// An operation of kind torque.
mpm::Torque bind_torque(const ScheduleOperation& operation);

}  // namespace physmas::bind

#endif
