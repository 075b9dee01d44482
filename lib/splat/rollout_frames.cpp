#include "splat/rollout_frames.h"

namespace physmas::splat {
namespace {

Eigen::Vector3f position_in(const RolloutFrame& frame, size_t q) {
  return {frame.position[3 * q], frame.position[3 * q + 1], frame.position[3 * q + 2]};
}
Eigen::Map<const RowMatrix3f> F_in(const RolloutFrame& frame, size_t q) {
  return Eigen::Map<const RowMatrix3f>(&frame.F[9 * q]);
}

}  // namespace

TransportedFrame::TransportedFrame(const RolloutFrame& frame, const SolverMap& map, const Carriers& carriers)
    : position_(carriers.empty() ? frame.position.size() / 3 : carriers.rest.size()), F_(position_.size()) {
  if (carriers.empty()) {
    for (size_t i = 0; i < position_.size(); ++i) {
      position_[i] = map.to_scene(position_in(frame, i).cast<double>()).cast<float>();
      F_[i] = F_in(frame, i);
    }
    return;
  }
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < position_.size(); ++i) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    RowMatrix3f F = RowMatrix3f::Zero();
    for (int k = 0; k < Carriers::kPerGaussian; ++k) {
      const float w = carriers.weight[i * Carriers::kPerGaussian + k];
      if (w == 0) continue;
      const int32_t q = carriers.particle[i * Carriers::kPerGaussian + k];
      const Eigen::Vector3f offset = F_in(frame, q) * (carriers.rest[i] - carriers.rest[carriers.gaussian[q]]);
      x += w * (position_in(frame, q) + offset).cast<double>();
      F += w * F_in(frame, q);
    }
    position_[i] = map.to_scene(x).cast<float>();
    F_[i] = F;
  }
}

}  // namespace physmas::splat
