// What the words of a prompt meant, for the record.
#ifndef PHYSMAS_PLAN_PROPOSAL_H
#define PHYSMAS_PLAN_PROPOSAL_H

#include "plan/prompt.h"
#include "records/json_fwd.h"

namespace physmas::plan {

// plan.json's `proposal`: every event as read, before anything was resolved against the inventory.
Json proposal_of(const Reading& reading);

}  // namespace physmas::plan

#endif
