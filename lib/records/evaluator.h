// The evaluator's predicates, which repairs and the screen share (paper, "Validity Gate, Ranking, and Tie Rules").
#ifndef PHYSMAS_RECORDS_EVALUATOR_H
#define PHYSMAS_RECORDS_EVALUATOR_H

#include "records/candidate.h"
#include "records/inventory.h"

namespace physmas {

// S-hat_r(k): the row's name holds a support token, or the candidate's visual label is rigid.
bool evaluator_support(const InventoryRow& row, const CandidateRow& candidate);

// C-hat_r(k): cohesive and not a support; granular branches (Sand, Snow) never are.
bool evaluator_cohesive(const InventoryRow& row, const CandidateRow& candidate);

}  // namespace physmas

#endif
