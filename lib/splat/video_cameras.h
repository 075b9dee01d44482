// The cameras that a video is seen with.
#ifndef PHYSMAS_SPLAT_VIDEO_CAMERAS_H
#define PHYSMAS_SPLAT_VIDEO_CAMERAS_H

#include <string>
#include <vector>

#include "records/cameras.h"
#include "records/execution.h"
#include "records/scene.h"
#include "records/state.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

// Whether a rollout has all frames of its run. One without them gets no video.
bool is_complete(const RolloutFrames& rollout, const ExecutionRecord& execution, const Scene& scene);

// Of the file, if one is given (an Error with exit code 3 unless it has one camera or one per frame); else, where the
// run specification has fit or orbit, fitted to this rollout alone; else the scene's own.
FittedCameras video_cameras(const Scene& scene, const State& state, const Gaussians& gaussians,
                            const RolloutFrames& rollout, const ExecutionRecord& execution,
                            const std::string& cameras_file);

struct FitCamerasOptions {
  std::string scene, state, out;  // the scene or its render slice, state.h5, cameras.json to write
  std::string widen;              // cameras of an earlier round, whose motion is kept in the picture; may be empty
  std::vector<std::string> rollouts;
};

// Fits one set of cameras to the motion of several rollouts and writes it. A rollout without a video counts with its
// rest frame.
void fit_cameras(const FitCamerasOptions& options);

}  // namespace physmas::splat

#endif
