// A frame with the objects' own turns and moves taken out of it: what turned is not flattened.
#ifndef PHYSMAS_SPLAT_OWN_FRAME_H
#define PHYSMAS_SPLAT_OWN_FRAME_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "records/render.h"
#include "records/scene.h"
#include "records/state.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

// The rigid motion that fits points best in the sense of least squares, every point counting alike: x = R (x0 - from) +
// to.
struct RigidMotion {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();                               // proper
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();  // centroids
  // sum (x - to) . R (x0 - from) over the root of sum |x - to|^2 times sum |x0 - from|^2, 0..1; 1 for a rigid motion.
  double likeness = 1;
  double degrees() const;  // 0..180
};

// members: indices of the points that are fitted; those that are not finite in either frame do not count. Where nothing
// is left the motion is none.
RigidMotion fit_rigid_motion(const TransportedFrame& first, const TransportedFrame& last,
                             const std::vector<int32_t>& members);

// Below that likeness an object has no shape left whose turn could be told, and is not turned back.
constexpr double kLeastLikeness = 0.5;

// What is measured of frame T-1 where the image boxes of `record` fail spread or flattening (paper, "Validity Gate,
// Ranking, and Tie Rules"); nothing where they hold, or where one of them is missing. record: with frames and
// endpoints. The boxes are measured as the endpoints are (foreground.h).
std::optional<OwnFrame> measure_own_frame(Renderer& renderer, const Gaussians& gaussians, const RolloutFrames& rollout,
                                          const Scene& scene, const State& state, const RenderOptions& options,
                                          const RenderRecord& record);

}  // namespace physmas::splat

#endif
