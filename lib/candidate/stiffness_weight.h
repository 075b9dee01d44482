// How much stiffer than the whole object a row is built (paper, "Candidate Construction and Repair Transforms").
#ifndef PHYSMAS_CANDIDATE_STIFFNESS_WEIGHT_H
#define PHYSMAS_CANDIDATE_STIFFNESS_WEIGHT_H

#include "records/inventory.h"

namespace physmas::candidate {

// omega_r: the first matching rule. support: S_r.
double stiffness_weight(const InventoryRow& row, bool support);

}  // namespace physmas::candidate

#endif
