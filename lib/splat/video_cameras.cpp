#include "splat/video_cameras.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/log.h"
#include "scene/gaussian_files.h"
#include "splat/fitted_camera.h"

namespace physmas::splat {
namespace {

void add_rollout(const Scene& scene, const State& state, const Gaussians& gaussians, const RolloutFrames& rollout,
                 const ExecutionRecord& execution, const std::vector<Camera>& base, FittedCameras& fitted) {
  const int frames = is_complete(rollout, execution, scene) ? rollout.count() : std::min(rollout.count(), 1);
  add_motion(
      gaussians, state, frames, [&](int t) { return rollout.frame(t); }, base, fitted);
  fitted.candidates.push_back(execution.candidate);
}

}  // namespace

bool is_complete(const RolloutFrames& rollout, const ExecutionRecord& execution, const Scene& scene) {
  return rollout.count() == scene.run.time.frames && !execution.diverged;
}

FittedCameras video_cameras(const Scene& scene, const State& state, const Gaussians& gaussians,
                            const RolloutFrames& rollout, const ExecutionRecord& execution,
                            const std::string& cameras_file) {
  if (!cameras_file.empty()) {
    FittedCameras shown = load_cameras(cameras_file);
    if (shown.cameras.size() != 1 && static_cast<int>(shown.cameras.size()) != scene.run.time.frames) {
      throw invalid_input({cameras_file, "/cameras", fmt::format("{} cameras", shown.cameras.size()),
                           fmt::format("one, or one per frame ({})", scene.run.time.frames)});
    }
    return shown;
  }
  FittedCameras shown;
  shown.cameras = scene.output_cameras;
  if (scene.run.render.camera_mode() == RunSpecification::Render::CameraMode::fixed) return shown;
  const std::vector<Camera> base = base_cameras(scene, gaussians);
  add_rollout(scene, state, gaussians, rollout, execution, base, shown);
  place_cameras(gaussians, base, shown);
  return shown;
}

void fit_cameras(const FitCamerasOptions& options) {
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  const State state = load_state(options.state);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);
  FittedCameras fitted;
  if (!options.widen.empty()) fitted = load_cameras(options.widen);
  fitted.mode = scene.run.render.camera_mode();
  const std::vector<Camera> base = base_cameras(scene, gaussians);
  Provenance provenance;
  provenance.tool = "pm-render";
  provenance.options.emplace_back("command", "fit");
  for (const std::string& input : {options.scene, options.state, options.widen}) {
    if (!input.empty()) provenance.add_input(input);
  }
  for (const std::string& path : options.rollouts) {
    const ExecutionRecord execution = load_execution_of(path);
    require_made_from(execution_path_of(path), options.state, false);
    const RolloutFrames rollout(path, state);
    add_rollout(scene, state, gaussians, rollout, execution, base, fitted);
    provenance.add_input(path);
  }
  place_cameras(gaussians, base, fitted);
  for (const Omission& omission : fitted.omitted) log_info(omission.what + ": " + omission.why);
  save_cameras(options.out, fitted, provenance);
}

}  // namespace physmas::splat
