// The three guards that may replace the posterior's mode, in their fixed order.
#ifndef PHYSMAS_MATERIAL_GUARDS_H
#define PHYSMAS_MATERIAL_GUARDS_H

#include <vector>

#include "material/posterior.h"
#include "records/evidence.h"
#include "records/inventory.h"

namespace physmas::material {

// ExpGuard (Eq. supp-materialguard), the multi-view VLM guard, the elastic-solid guard (Eq. supp-expected-elastic).
// Reads expected_labels, role_lookup and posterior of `evidence`; fills guards (each with every value it compared),
// label m_r and confidence P_r(m_r). The posterior is not recomputed in between.
void apply_guards(EvidenceRow& evidence, const InventoryRow& row, const std::vector<ValidVlmRecord>& vlm);

}  // namespace physmas::material

#endif
