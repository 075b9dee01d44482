// The pictures of a video: Gaussians on their floor, with signs of what acts on them where the run asks for those.
//
// Measurements are never taken from them: they are of the Gaussians alone.
#ifndef PHYSMAS_SPLAT_VIDEO_PICTURES_H
#define PHYSMAS_SPLAT_VIDEO_PICTURES_H

#include <memory>
#include <string>

#include "records/scene.h"
#include "records/state.h"
#include "scene/image.h"
#include "splat/action_signs.h"
#include "splat/floor_shadow.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

// What a video of this run is rendered with.
RenderOptions video_options(const RunSpecification::Render& render);

struct PictureSettings {
  std::string scene;      // its file, for errors
  std::string rollout;    // its file, whose execution record names the candidate record that it was made from
  std::string floor;      // none | shadow; empty: as the run specification says
  std::string candidate;  // candidate record, for render.agents: true
  std::string id;         // of the rollout's candidate
};

class VideoPictures {
 public:
  // All of them outlive this. A slice without the colliders that a floor needs, signs without a candidate record and a
  // record of another candidate, or another one of that name, are Errors (exit codes 3, 2, 3).
  VideoPictures(const Scene& scene, const State& state, const Gaussians& gaussians, const PictureSettings& settings);

  // Of a frame that was rendered as `image`, in 8 bits `quantized`. time: seconds of the rollout.
  Image picture(const RenderedImage& image, const Image& quantized, const TransportedFrame& frame, double time,
                const Camera& camera);
  bool has_signs() const { return signs_ != nullptr; }

 private:
  std::unique_ptr<FloorShadow> floor_;
  std::unique_ptr<ActionSigns> signs_;
};

}  // namespace physmas::splat

#endif
