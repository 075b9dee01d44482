// What counts as a support, and what as cohesive: the paper has a definition for each of its three users, which differ
// in their words, in the fields that they read and in how they match. All are here, side by side.
//
//                        user                                     fields                        match
//   guard_structural     the elastic-solid guard of materials     physics group, role           whole words
//   construction_*       candidate construction                   name, physics group, role     substrings; label
//   evaluator_*          repairs and the screen                   name (cohesive: all fields)   substrings; label
#ifndef PHYSMAS_RECORDS_SUPPORT_H
#define PHYSMAS_RECORDS_SUPPORT_H

#include "records/candidate.h"
#include "records/inventory.h"

namespace physmas {

// Whether the words of the row name a load-bearing or rigid part (paper, "Evidence Aggregation and Continuous
// Parameters", the elastic-solid guard).
bool guard_structural(const InventoryRow& row);

// S_r (paper, "Candidate Construction and Repair Transforms"): a support token; else no soft token and a rigid label.
// label: the row's selected visual label m_r.
bool construction_support(const InventoryRow& row, int label);

// C_r: 0 for a support; a cohesion token in the fields or in the label's name; else branch Map(label) Foam, Plasticine
// or Jelly with a label that is not rigid.
bool construction_cohesive(const InventoryRow& row, int label);

// S-hat_r(k) (paper, "Validity Gate, Ranking, and Tie Rules"): the row's name holds a support token, or the candidate's
// visual label is rigid.
bool evaluator_support(const InventoryRow& row, const CandidateRow& candidate);

// C-hat_r(k): cohesive and not a support; granular branches (Sand, Snow) never are.
bool evaluator_cohesive(const InventoryRow& row, const CandidateRow& candidate);

}  // namespace physmas

#endif
