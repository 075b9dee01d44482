// The material stage: from rows, masks and observations to the evidence record.
#ifndef PHYSMAS_MATERIAL_EVIDENCE_H
#define PHYSMAS_MATERIAL_EVIDENCE_H

#include <optional>
#include <vector>

#include "records/evidence.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/material_records.h"

namespace physmas::material {

// gamma^mask per row, [inventory.rows] (paper, Eq. supp-maskconfidence): the mean confidence, with the floor of
// lifting, over the views whose mask of the row is not empty; 0 (the paper's sentinel for "unavailable") where no view
// has one.
std::vector<double> mask_confidences(const Inventory& inventory, const std::vector<ViewMasks>& views);

// One row psi_r. Residual rows skip every source: unit Plastic and its defaults.
// gaussians: how many carry this row; whole_label: visual label of the whole-object record, or -1.
EvidenceRow row_evidence(const InventoryRow& row, const RowObservations& observations, long gaussians,
                         double mask_confidence, int whole_label);

// Fills all rows in inventory order and the whole-object record; what was left out is appended to `omitted`.
// gaussians, mask_confidence: [inventory.rows]. records: empty when there is neither a model nor an authored file.
void reason_about_materials(Evidence& evidence, const Inventory& inventory, const std::vector<long>& gaussians,
                            const std::vector<double>& mask_confidence, const std::optional<MaterialRecords>& records);

}  // namespace physmas::material

#endif
