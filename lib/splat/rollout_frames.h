// A rollout as the renderer sees it: its Gaussians in scene space, frame by frame.
#ifndef PHYSMAS_SPLAT_ROLLOUT_FRAMES_H
#define PHYSMAS_SPLAT_ROLLOUT_FRAMES_H

#include <string>
#include <utility>
#include <vector>

#include "records/rollout.h"
#include "records/state.h"
#include "splat/renderer.h"

namespace physmas::splat {

// The Gaussians of one rollout frame in scene space (paper, Eq. gaussiantransport): mu = (x - d) / s, and F as it is,
// because L = s I commutes with it. Where carriers move the others, a Gaussian i has the weighted means over its
// carriers k, F = sum w_k F_k and x = sum w_k (x_k + F_k (X_i - X_k)), X at rest: what turns or stretches as a whole
// carries it exactly.
class TransportedFrame {
 public:
  TransportedFrame(const RolloutFrame& frame, const SolverMap& map, const Carriers& carriers = {});
  // position: [N_G] scene space; F: [N_G].
  TransportedFrame(std::vector<Eigen::Vector3f> position, std::vector<RowMatrix3f> F)
      : position_(std::move(position)), F_(std::move(F)) {}
  // Views of this object's arrays: it must outlive the use.
  Deformation deformation() const { return {position_.data(), F_.data()}; }
  const Eigen::Vector3f& position(size_t i) const { return position_[i]; }
  const RowMatrix3f& F(size_t i) const { return F_[i]; }

 private:
  std::vector<Eigen::Vector3f> position_;  // [N_G] scene space
  std::vector<RowMatrix3f> F_;             // [N_G]
};

// The one way from a rollout to pictures, files and measures of its frames.
class RolloutFrames {
 public:
  // state: whose Gaussians, carriers and solver map the rollout has; it must outlive this. A rollout of another number
  // of Gaussians is an Error (exit code 3).
  RolloutFrames(const std::string& path, const State& state) : reader_(path, state.carrier_count()), state_(state) {}
  int count() const { return reader_.frame_count(); }
  double time(int t) const { return reader_.time(t); }  // s
  // t: 0..count() - 1. Values may be NaN in a diverged rollout; the renderer skips such Gaussians.
  TransportedFrame frame(int t) const { return TransportedFrame(reader_.frame(t), state_.map, state_.carriers); }

 private:
  RolloutReader reader_;
  const State& state_;
};

}  // namespace physmas::splat

#endif
