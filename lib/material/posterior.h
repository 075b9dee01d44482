// Evidence sources, label scores and the posterior of a row (paper, "Evidence Aggregation and Continuous Parameters").
#ifndef PHYSMAS_MATERIAL_POSTERIOR_H
#define PHYSMAS_MATERIAL_POSTERIOR_H

#include <string>
#include <vector>

#include "records/evidence.h"
#include "records/inventory.h"
#include "records/material_records.h"

namespace physmas::material {

// Unnormalised source coefficients; their sum need not be one.
constexpr double kSchemaCoefficient = 0.25;
constexpr double kCropCoefficient = 0.35;
constexpr double kVlmCoefficient = 0.30;
constexpr double kRoleCoefficient = 0.10;
constexpr double kWholeCoefficient = 0.05;

// Canonical, deduplicated labels in the authored order; names that are not among the fourteen go to `unknown`.
std::vector<int> canonical_labels(const std::vector<std::string>& names, std::vector<std::string>& unknown);

// A vision-language record that counts: successful, not abstaining, with a confidence and a positive sum.
struct ValidVlmRecord {
  int index = 0;              // in the row's list
  double confidence = 0;      // 0..1
  int canonical_views = 0;    // distinct names among front, right, back, left
  LabelScores probabilities;  // sum to 1
};
std::vector<ValidVlmRecord> valid_vlm_records(const std::vector<VlmRecord>& records);

// Fills sources, role_lookup, scores and the fallback flag of a semantic row whose expected_labels are set.
// whole_label: visual label of the whole-object record, or -1.
void accumulate_scores(EvidenceRow& evidence, const InventoryRow& row, const RowObservations& observations,
                       int whole_label);

// P_r (Eq. supp-materialposterior) from evidence.scores: fourteen labels, descending, ties by insertion, then table
// order. Fills posterior and entropy.
void normalise_scores(EvidenceRow& evidence);

}  // namespace physmas::material

#endif
