// Continuous E and nu: decoding, weighted moments, dispersions, part confidence, and the whole-object record.
#ifndef PHYSMAS_MATERIAL_STATISTICS_H
#define PHYSMAS_MATERIAL_STATISTICS_H

#include <optional>
#include <vector>

#include "records/evidence.h"
#include "records/material_records.h"

namespace physmas::material {

// log10 of the decoded Young's modulus [Pa] (Eq. decode), or of the crop's own E; empty when it is not finite.
std::optional<double> decoded_log10_E(const CropRecord& crop);
// The decoded Poisson's ratio (Eq. decode), or the crop's own; empty when it is not finite.
std::optional<double> decoded_nu(const CropRecord& crop);

// Fills E, nu, their dispersions (Eqs. moments, supp-posteriorcenter, dispersion) and part_confidence (Eq.
// supp-partconfidence) from the valid crops; reads label, confidence, entropy and mask_confidence. Without crops this
// gives the defaults of the label, which is all that residual rows have.
void pool_statistics(EvidenceRow& evidence, const std::vector<CropRecord>& crops);

// The auxiliary whole-object record. Absent, or without a canonical label: the fixed fallback (Plasticine, 5e5 Pa,
// 0.476, 5000 kg/m^3), literally.
WholeObject whole_object_record(const std::optional<WholeObjectObservations>& observations);

}  // namespace physmas::material

#endif
