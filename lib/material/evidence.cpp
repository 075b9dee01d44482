#include "material/evidence.h"

#include "material/guards.h"
#include "material/posterior.h"
#include "material/statistics.h"
#include "records/json.h"

namespace physmas::material {

std::vector<double> mask_confidences(const Inventory& inventory, const std::vector<ViewMasks>& views) {
  std::vector<double> confidences(inventory.rows.size(), 0.0);
  for (size_t r = 0; r < confidences.size(); ++r) {
    int count = 0;
    for (const ViewMasks& view : views) {
      if (view.rows[r].area() == 0) continue;
      confidences[r] += view.rows[r].floored_confidence();
      ++count;
    }
    if (count > 0) confidences[r] /= count;
  }
  return confidences;
}

EvidenceRow row_evidence(const InventoryRow& row, const RowObservations& observations, long gaussians,
                         double mask_confidence, int whole_label) {
  EvidenceRow evidence;
  evidence.key = row.key();
  evidence.residual = row.residual;
  evidence.gaussians = gaussians;
  evidence.mask_confidence = mask_confidence;
  if (row.residual) {
    evidence.fallback = true;
    evidence.scores = {{kPlastic, 1.0}};
    normalise_scores(evidence);
    evidence.label = kPlastic;
    evidence.confidence = 1;
    pool_statistics(evidence, {});
    return evidence;
  }
  if (!observations.crops.empty() || !observations.vlm.empty())
    evidence.observations = {{"crops", to_json(observations.crops)}, {"vlm", to_json(observations.vlm)}};
  std::vector<std::string> unknown;
  evidence.expected_labels = canonical_labels(row.expected_labels, unknown);
  accumulate_scores(evidence, row, observations, whole_label);
  evidence.stated = observations.stated;
  if (evidence.stated.label) {
    // What is stated is known: there is no second label.
    evidence.scores = {{*evidence.stated.label, 1.0}};
    evidence.fallback = false;
  }
  normalise_scores(evidence);
  apply_guards(evidence, row, valid_vlm_records(observations.vlm));
  if (evidence.stated.label) {
    const int before = evidence.label;
    evidence.label = *evidence.stated.label;
    evidence.confidence = 1;
    evidence.guards.push_back(
        {"stated", before != evidence.label, evidence.label, {{"label_before", kLabels[before].name}}});
  }
  pool_statistics(evidence, observations.crops);
  return evidence;
}

void reason_about_materials(Evidence& evidence, const Inventory& inventory, const std::vector<long>& gaussians,
                            const std::vector<double>& mask_confidence, const std::optional<MaterialRecords>& records) {
  if (!records) {
    evidence.omitted.push_back(
        {"crop and vision-language evidence", "neither a model nor a file of records was given"});
  }
  evidence.whole_object = whole_object_record(records ? records->whole_object : std::nullopt);
  if (evidence.whole_object.label < 0) {
    evidence.omitted.push_back(
        {"whole-object evidence", "no full-object record with a canonical label; the fixed fallback stands in"});
  }
  static const RowObservations kNone;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    const InventoryRow& row = inventory.rows[r];
    const RowObservations& observations = records ? records->rows[r] : kNone;
    std::vector<std::string> unknown;
    canonical_labels(row.expected_labels, unknown);
    for (const std::string& name : unknown) {
      evidence.omitted.push_back(
          {"expected label \"" + name + "\" of " + row.key(), "it is not one of the fourteen visual labels"});
    }
    if (records && row.residual && !(observations.crops.empty() && observations.vlm.empty())) {
      evidence.omitted.push_back({"observations of " + row.key(), "a residual row takes no evidence"});
    }
    if (records && row.residual && !observations.stated.empty())
      evidence.omitted.push_back({"what is stated of " + row.key(), "a residual row is nobody's to describe"});
    evidence.rows.push_back(
        row_evidence(row, observations, gaussians[r], mask_confidence[r], evidence.whole_object.label));
  }
}

}  // namespace physmas::material
