#include "splat/middle_box.h"

#include <algorithm>
#include <vector>

namespace physmas::splat {

Eigen::AlignedBox3d middle_box(const Gaussians& gaussians) {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = low;
  std::vector<float> values(gaussians.size());
  for (int axis = 0; axis < 3 && !values.empty(); ++axis) {
    for (size_t i = 0; i < values.size(); ++i) values[i] = gaussians.position[i][axis];
    const auto quantile = [&](double part) {
      auto nth = values.begin() + static_cast<std::ptrdiff_t>(part * (values.size() - 1));
      std::nth_element(values.begin(), nth, values.end());
      return static_cast<double>(*nth);
    };
    low[axis] = quantile(0.05), high[axis] = quantile(0.95);
  }
  return {low, high};
}

}  // namespace physmas::splat
