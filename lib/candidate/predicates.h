// The predicates of candidate construction (paper, "Candidate Construction and Repair Transforms").
#ifndef PHYSMAS_CANDIDATE_PREDICATES_H
#define PHYSMAS_CANDIDATE_PREDICATES_H

#include "records/inventory.h"

namespace physmas::candidate {

// S_r: a support token in name, physics group and role; else no soft token and a rigid label.
// label: the row's selected visual label m_r.
bool is_support(const InventoryRow& row, int label);

// C_r: 0 for a support; a cohesion token in name, physics group, role and label; else branch Map(label) Foam,
// Plasticine or Jelly with a label that is not rigid.
bool is_cohesive(const InventoryRow& row, int label);

// omega_r: the stiffness weight, the first matching rule.
double stiffness_weight(const InventoryRow& row, int label);

}  // namespace physmas::candidate

#endif
