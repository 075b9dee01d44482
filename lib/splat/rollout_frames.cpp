#include "splat/rollout_frames.h"

namespace physmas::splat {

TransportedFrame::TransportedFrame(const RolloutFrame& frame, const SolverMap& map)
    : position_(frame.position.size() / 3), F_(position_.size()) {
  for (size_t i = 0; i < position_.size(); ++i) {
    const Eigen::Vector3d x(frame.position[3 * i], frame.position[3 * i + 1], frame.position[3 * i + 2]);
    position_[i] = map.to_scene(x).cast<float>();
    F_[i] = Eigen::Map<const RowMatrix3f>(&frame.F[9 * i]);
  }
}

}  // namespace physmas::splat
