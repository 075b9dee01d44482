// The fixed role vocabulary: words in a row's name and role that speak for visual labels.
#ifndef PHYSMAS_MATERIAL_ROLE_LOOKUP_H
#define PHYSMAS_MATERIAL_ROLE_LOOKUP_H

#include "records/evidence.h"
#include "records/inventory.h"

namespace physmas::material {

struct RoleEvidence {
  LabelScores sums;     // confidences of the matching rules, summed per label; insertion order
  LabelScores maximum;  // R_r(m), the maximum confidence per label; same order
};

// Scans name and structural role; a rule counts once however many of its words match.
RoleEvidence look_up_role(const InventoryRow& row);

}  // namespace physmas::material

#endif
