// Small helpers on ordered label scores.
#ifndef PHYSMAS_MATERIAL_LABEL_SCORES_H
#define PHYSMAS_MATERIAL_LABEL_SCORES_H

#include "records/evidence.h"

namespace physmas::material {

// The score of `label`, appended with zero when it is not there yet: this is what keeps the insertion order.
inline double& entry(LabelScores& scores, int label) {
  for (auto& [known, score] : scores) {
    if (known == label) return score;
  }
  scores.emplace_back(label, 0.0);
  return scores.back().second;
}

// The score of `label`, 0 when it is not there.
inline double value(const LabelScores& scores, int label) {
  for (const auto& [known, score] : scores) {
    if (known == label) return score;
  }
  return 0;
}

inline bool contains(const LabelScores& scores, int label) {
  for (const auto& [known, score] : scores) {
    if (known == label) return true;
  }
  return false;
}

}  // namespace physmas::material

#endif
