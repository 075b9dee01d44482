#include "material/role_lookup.h"

#include <algorithm>

#include "material/label_scores.h"
#include "records/text_match.h"

namespace physmas::material {
namespace {

struct RoleRule {
  std::vector<const char*> words;
  LabelScores labels;
};

// Paper, "Evidence Aggregation and Continuous Parameters", the fixed lookup, in the printed order.
const std::vector<RoleRule>& role_rules() {
  static const std::vector<RoleRule> kRules = {
      {{"head", "blade", "tip", "edge", "impact", "metal"}, {{kMetal, 0.75}}},
      {{"handle", "grip", "shaft"}, {{kWood, 0.55}, {kPlastic, 0.45}}},
      {{"wheel", "tire", "tyre", "sole"}, {{kRubber, 0.80}}},
      {{"cushion", "pad", "pillow", "foam"}, {{kFoam, 0.75}}},
      {{"cloth", "fabric", "lace", "upper"}, {{kFabric, 0.65}}},
      {{"plate", "bowl", "ceramic"}, {{kCeramic, 0.55}, {kPlastic, 0.35}}},
      {{"frosting", "cream", "cake", "soft"}, {{kFoam, 0.55}, {kPlasticine, 0.35}}},
  };
  return kRules;
}

}  // namespace

RoleEvidence look_up_role(const InventoryRow& row) {
  const RowText text = row_text(row, {row.name, row.structural_role});
  RoleEvidence evidence;
  for (const RoleRule& rule : role_rules()) {
    if (!contains_any(text, rule.words)) continue;
    for (const auto& [label, confidence] : rule.labels) {
      entry(evidence.sums, label) += confidence;
      double& maximum = entry(evidence.maximum, label);
      maximum = std::max(maximum, confidence);
    }
  }
  return evidence;
}

}  // namespace physmas::material
