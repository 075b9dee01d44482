// From solver space back to the scene: what a rollout frame means for the Gaussians.
#ifndef PHYSMAS_SPLAT_TRANSPORT_H
#define PHYSMAS_SPLAT_TRANSPORT_H

#include <vector>

#include "records/rollout.h"
#include "records/state.h"
#include "splat/renderer.h"

namespace physmas::splat {

// The Gaussians of one rollout frame in scene space (paper, Eq. gaussiantransport): mu = (x - d) / s, and F as it is,
// because L = s I commutes with it.
class TransportedFrame {
 public:
  TransportedFrame(const RolloutFrame& frame, const SolverMap& map) {
    const size_t count = frame.position.size() / 3;
    position_.resize(count);
    F_.resize(count);
    for (size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d x(frame.position[3 * i], frame.position[3 * i + 1], frame.position[3 * i + 2]);
      position_[i] = map.to_scene(x).cast<float>();
      F_[i] = Eigen::Map<const RowMatrix3f>(&frame.F[9 * i]);
    }
  }
  // Views of this object's arrays: it must outlive the use.
  Deformation deformation() const { return {position_.data(), F_.data()}; }
  const Eigen::Vector3f& position(size_t i) const { return position_[i]; }
  const RowMatrix3f& F(size_t i) const { return F_[i]; }

 private:
  std::vector<Eigen::Vector3f> position_;  // [N_G] scene space
  std::vector<RowMatrix3f> F_;             // [N_G]
};

}  // namespace physmas::splat

#endif
