#include "records/evaluator.h"

#include "records/text_match.h"

namespace physmas {

bool evaluator_support(const InventoryRow& row, const CandidateRow& candidate) {
  return contains_any(match_text({row.name}), {"plate", "dish", "tray", "bowl", "base support", "support", "stand",
                                               "holder", "case", "shell", "frame"}) ||
         is_rigid_label(candidate.label);
}

bool evaluator_cohesive(const InventoryRow& row, const CandidateRow& candidate) {
  if (evaluator_support(row, candidate)) return false;
  const Branch branch = candidate.branch;
  if (branch == Branch::sand || branch == Branch::snow) return false;
  const std::string text =
      match_text({row.name, row.physics_group, row.structural_role, kLabels[candidate.label].name});
  if (contains_any(text, {"body", "base", "core", "filling", "cream", "frosting", "icing", "soft", "cushion", "pad",
                          "foam", "sponge", "rubber", "gel", "fruit", "food"})) {
    return true;
  }
  return (branch == Branch::foam || branch == Branch::plasticine || branch == Branch::jelly) &&
         !is_rigid_label(candidate.label);
}

}  // namespace physmas
