// What a material field says of the rows.
#ifndef PHYSMAS_MATERIAL_FIELD_EVIDENCE_H
#define PHYSMAS_MATERIAL_FIELD_EVIDENCE_H

#include <string>

#include "records/evidence.h"
#include "records/state.h"

namespace physmas::material {

// Rows whose particles have samples take the medians of these as their E and nu, and keep label, branch, dispersions
// and confidences; what was counted and clamped stands in `field` of the row. A state without a field changes nothing.
// evidence: rows in the state's order.
void take_field(Evidence& evidence, const State& state);

// A line about the row's field, for people; where much of it was clamped, what to do.
std::string field_line(const EvidenceRow& row);

}  // namespace physmas::material

#endif
