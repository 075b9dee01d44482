#include "candidate/stiffness_weight.h"

#include "records/text_match.h"

namespace physmas::candidate {

double stiffness_weight(const InventoryRow& row, bool support) {
  if (support) return 1.6;
  const RowText text = row_text(row, {row.name, row.physics_group, row.structural_role});
  if (contains_any(text, {"candle", "stem", "stick", "handle"})) return 1.45;
  if (contains_any(text, {"fruit", "strawberry", "berry", "decoration"})) return 1.25;
  if (contains_any(text, {"cream", "frosting", "icing"})) return 1.05;
  return 1;
}

}  // namespace physmas::candidate
