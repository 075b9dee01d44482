// Cameras that keep what moves in the picture.
#ifndef PHYSMAS_SPLAT_FITTED_CAMERA_H
#define PHYSMAS_SPLAT_FITTED_CAMERA_H

#include <functional>
#include <vector>

#include "records/cameras.h"
#include "records/scene.h"
#include "records/state.h"
#include "scene/gaussians.h"
#include "splat/rollout_frames.h"

namespace physmas::splat {

constexpr double kFreeEdge = 0.04;     // part of the half picture that stays free at each edge
constexpr double kFarthest = 2.5;      // a fitted camera stands at most this many times as far
constexpr double kOrbitSpeed = 20;     // degrees per second, from the front towards the right
constexpr double kMayLeave = 0.001;    // part of an object's Gaussians that may pass each edge in a frame
constexpr float kFaintOpacity = 0.05;  // Gaussians below it do not count

// The cameras that fitting starts from: the scene's own output cameras, or, for `orbit`, its one camera turned about
// the up axis through the scene's middle, one for each frame. An Error (exit code 3) when an orbit is asked of a scene
// whose cameras already move.
std::vector<Camera> base_cameras(const Scene& scene, const Gaussians& gaussians);

// Adds frames 0..frames - 1, as `frame_at` gives them, to what `fitted` has reached so far. Per frame, object and edge
// the outermost kMayLeave of the Gaussians do not count, so that a few grains do not move the camera; neither does what
// is already beyond the edge in the rest frame, as far as it is.
void add_motion(const Gaussians& gaussians, const State& state, int frames,
                const std::function<TransportedFrame(int)>& frame_at, const std::vector<Camera>& base,
                FittedCameras& fitted);

// Sets the cameras, their distance and what is omitted from what was reached: every base camera is moved along its own
// axes by one offset for all of them and keeps its direction and lens. It moves back just as far as the motion needs,
// never forward and at most to kFarthest times its distance from the scene's middle, and then to the side as little as
// possible; where nothing leaves the picture nothing changes. Beyond kFarthest the rest scene stays in the picture and
// the motion is seen as far as that allows.
void place_cameras(const Gaussians& gaussians, const std::vector<Camera>& base, FittedCameras& fitted);

}  // namespace physmas::splat

#endif
