#include "records/labels.h"

#include <strings.h>

#include <cmath>

namespace physmas {

double LabelPrior::E_default() const {
  return std::sqrt(E_lo * E_hi);
}

std::optional<int> find_label(const std::string& name) {
  for (int i = 0; i < kLabelCount; ++i) {
    if (strcasecmp(name.c_str(), kLabels[i].name) == 0) return i;
  }
  return std::nullopt;
}

std::optional<Branch> find_branch(const std::string& name) {
  for (int i = 0; i < kBranchCount; ++i) {
    if (strcasecmp(name.c_str(), kBranchNames[i]) == 0) return static_cast<Branch>(i);
  }
  return std::nullopt;
}

}  // namespace physmas
