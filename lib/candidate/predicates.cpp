#include "candidate/predicates.h"

#include "records/labels.h"
#include "records/text_match.h"

namespace physmas::candidate {
namespace {

std::string text_of(const InventoryRow& row) {
  return match_text({row.name, row.physics_group, row.structural_role});
}

}  // namespace

bool is_support(const InventoryRow& row, int label) {
  const std::string text = text_of(row);
  if (contains_any(text, {"plate", "dish", "tray", "stand", "support", "holder", "structural", "rigid", "load bearing",
                          "load-bearing", "frame", "shell", "blade", "head", "tip", "impact part"})) {
    return true;
  }
  if (contains_any(text, {"soft", "deformable", "compressible", "cushion", "foam", "sponge", "flesh", "fruit", "food",
                          "filling", "cream", "frosting", "icing"})) {
    return false;
  }
  return is_rigid_label(label);
}

bool is_cohesive(const InventoryRow& row, int label) {
  if (is_support(row, label)) return false;
  const std::string text = match_text({row.name, row.physics_group, row.structural_role, kLabels[label].name});
  if (contains_any(text, {"body",   "base",     "core",  "main",  "bulk",    "filling", "coating",    "layer",
                          "cream",  "frosting", "icing", "fruit", "organic", "soft",    "deformable", "foam",
                          "sponge", "rubber",   "gel",   "cloth", "fabric",  "leather", "pad"})) {
    return true;
  }
  const Branch branch = kLabels[label].branch;
  return (branch == Branch::foam || branch == Branch::plasticine || branch == Branch::jelly) && !is_rigid_label(label);
}

double stiffness_weight(const InventoryRow& row, int label) {
  if (is_support(row, label)) return 1.6;
  const std::string text = text_of(row);
  if (contains_any(text, {"candle", "stem", "stick", "handle"})) return 1.45;
  if (contains_any(text, {"fruit", "strawberry", "berry", "decoration"})) return 1.25;
  if (contains_any(text, {"cream", "frosting", "icing"})) return 1.05;
  return 1;
}

}  // namespace physmas::candidate
