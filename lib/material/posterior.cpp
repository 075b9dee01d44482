#include "material/posterior.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "material/label_scores.h"
#include "material/role_lookup.h"
#include "records/text_match.h"

namespace physmas::material {
namespace {

LabelScores scaled(LabelScores scores, double factor, double divisor = 1) {
  for (auto& [label, score] : scores) score = factor * (score / divisor);
  return scores;
}

LabelScores schema_scores(const std::vector<int>& expected) {
  LabelScores scores;
  for (int label : expected) scores.emplace_back(label, kSchemaCoefficient / expected.size());
  return scores;
}

LabelScores crop_scores(const std::vector<CropRecord>& crops) {
  LabelScores sums;
  int count = 0;
  for (const CropRecord& crop : crops) {
    if (!crop.valid) continue;
    ++count;
    for (const auto& [label, score] : crop.evidence) entry(sums, label) += score;
  }
  return count == 0 ? sums : scaled(sums, kCropCoefficient, count);
}

LabelScores vlm_scores(const std::vector<VlmRecord>& records) {
  LabelScores sums;
  const std::vector<ValidVlmRecord> valid = valid_vlm_records(records);
  for (const ValidVlmRecord& record : valid) {
    for (const auto& [label, p] : record.probabilities) entry(sums, label) += record.confidence * p;
  }
  return valid.empty() ? sums : scaled(sums, kVlmCoefficient, static_cast<double>(valid.size()));
}

}  // namespace

std::vector<int> canonical_labels(const std::vector<std::string>& names, std::vector<std::string>& unknown) {
  std::vector<int> labels;
  for (const std::string& name : names) {
    const auto label = find_label(name);
    if (!label) {
      unknown.push_back(name);
    } else if (std::find(labels.begin(), labels.end(), *label) == labels.end()) {
      labels.push_back(*label);
    }
  }
  return labels;
}

std::vector<ValidVlmRecord> valid_vlm_records(const std::vector<VlmRecord>& records) {
  std::vector<ValidVlmRecord> valid;
  for (size_t i = 0; i < records.size(); ++i) {
    const VlmRecord& record = records[i];
    double sum = 0;
    for (const auto& [label, p] : record.probabilities) sum += p;
    if (!record.success || record.abstain || !record.confidence || !(sum > 0) || !std::isfinite(sum)) continue;
    std::set<std::string> views;
    for (const std::string& view : record.views) {
      const std::string name = match_text({view});
      if (name == "front" || name == "right" || name == "back" || name == "left") views.insert(name);
    }
    valid.push_back({static_cast<int>(i), *record.confidence, static_cast<int>(views.size()),
                     scaled(record.probabilities, 1, sum)});
  }
  return valid;
}

void accumulate_scores(EvidenceRow& evidence, const InventoryRow& row, const RowObservations& observations,
                       int whole_label) {
  const RoleEvidence role = look_up_role(row);
  evidence.role_lookup = role.maximum;
  LabelScores whole;
  if (whole_label >= 0) whole.emplace_back(whole_label, kWholeCoefficient);
  const std::vector<std::pair<std::string, LabelScores>> sources = {{"schema", schema_scores(evidence.expected_labels)},
                                                                    {"crop", crop_scores(observations.crops)},
                                                                    {"vlm", vlm_scores(observations.vlm)},
                                                                    {"role", scaled(role.sums, kRoleCoefficient)},
                                                                    {"whole", whole}};
  double total = 0;
  for (const auto& [name, scores] : sources) {
    if (scores.empty()) continue;
    evidence.sources.emplace_back(name, scores);
    for (const auto& [label, score] : scores) {
      entry(evidence.scores, label) += score;
      total += score;
    }
  }
  evidence.fallback = !(total > 0);
  if (evidence.fallback) evidence.scores = {{kPlastic, 1.0}};
}

void normalise_scores(EvidenceRow& evidence) {
  double sum = 0;
  for (const auto& [label, score] : evidence.scores) sum += score;
  evidence.posterior = evidence.scores;
  for (auto& [label, p] : evidence.posterior) p /= sum;
  for (int label = 0; label < kLabelCount; ++label) {
    if (!contains(evidence.posterior, label)) evidence.posterior.emplace_back(label, 0.0);
  }
  // Stable: ties keep the insertion order.
  std::stable_sort(evidence.posterior.begin(), evidence.posterior.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  evidence.entropy = 0;
  for (const auto& [label, p] : evidence.posterior) {
    if (p > 0) evidence.entropy -= p * std::log(p);
  }
}

}  // namespace physmas::material
