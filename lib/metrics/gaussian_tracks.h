// Exact tracks and silhouettes of our own runs: projected Gaussians instead of a video tracker.
#ifndef PHYSMAS_METRICS_GAUSSIAN_TRACKS_H
#define PHYSMAS_METRICS_GAUSSIAN_TRACKS_H

#include <vector>

#include "metrics/query_grid.h"
#include "records/inventory.h"
#include "records/scene.h"
#include "records/state.h"
#include "scene/gaussians.h"
#include "splat/rollout_frames.h"

namespace physmas::metrics {

// When a point of track_target is visible, for the metrics record.
constexpr char kExactVisibility[] =
    "the mean projects into the target's silhouette, no deeper behind the rendered depth there than in frame 0, give "
    "or "
    "take 1/400 of the scene's size and three of the Gaussian's standard deviations along the ray";

struct TargetMotion {
  Tracks tracks;
  std::vector<long> areas;  // visible target pixels per frame
};

// Gaussians that the query grid hits in frame 0 of the reference: under each query pixel inside the target's mask,
// eroded by one pixel, the target Gaussian with the largest blending weight there; one that lies under two query pixels
// enters once.
// target: [N_G] 1 where the Gaussian belongs to the target. Returns Gaussian indices in grid order.
std::vector<int> choose_queries(const Scene& scene, const Gaussians& gaussians, const splat::RolloutFrames& rollout,
                                const std::vector<uint8_t>& target);

// Tracks of the query Gaussians' means and the target's visible silhouette, all Gaussians as occluders, over all
// frames. A point is visible by kExactVisibility: other objects hide it, and so does its own target when it turns to
// the back or is folded under. The depth is the mean by blending weight that the renderer gives (splat::RenderedImage),
// the tolerance splat::depth_slack, as in lifting; in soft or glassy matter what a pixel shows lies behind that mean,
// so how far it does in frame 0 is added.
TargetMotion track_target(const Scene& scene, const Gaussians& gaussians, const splat::RolloutFrames& rollout,
                          const std::vector<uint8_t>& target, const std::vector<int>& queries);

// [N_G] 1 where the Gaussian belongs to `target`, an object id or a row key; empty: the whole scene. An Error (exit
// code 2) lists the objects when there is no such target.
std::vector<uint8_t> target_gaussians(const Inventory& inventory, const State& state, const std::string& target);

// The target's visible silhouette in every frame, 255 inside, all Gaussians as occluders.
std::vector<Image> target_silhouettes(const Scene& scene, const Gaussians& gaussians,
                                      const splat::RolloutFrames& rollout, const std::vector<uint8_t>& target);

}  // namespace physmas::metrics

#endif
