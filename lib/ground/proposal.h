// What the words of a prompt meant, for the record.
#ifndef PHYSMAS_GROUND_PROPOSAL_H
#define PHYSMAS_GROUND_PROPOSAL_H

#include "ground/prompt.h"
#include "records/json.h"

namespace physmas::ground {

// plan.json's `proposal`: every event as read, before anything was resolved against the inventory.
Json proposal_of(const Reading& reading);

}  // namespace physmas::ground

#endif
