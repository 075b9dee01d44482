#include "splat/best_video.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/log.h"
#include "records/execution.h"
#include "records/scene.h"
#include "records/state.h"
#include "scene/gaussian_files.h"
#include "scene/image_file.h"
#include "splat/quantize.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"
#include "splat/video.h"
#include "splat/video_cameras.h"
#include "splat/video_pictures.h"

namespace physmas::splat {
namespace {

std::vector<const ScreenedCandidate*> by_rank(const ScreenRecord& screen) {
  std::vector<const ScreenedCandidate*> candidates;
  for (const ScreenedCandidate& c : screen.candidates) candidates.push_back(&c);
  std::sort(candidates.begin(), candidates.end(), [](const auto* a, const auto* b) { return a->rank < b->rank; });
  return candidates;
}

}  // namespace

std::vector<std::string> reasons_of(const ScreenedCandidate& candidate, const ScreenRecord& screen) {
  std::vector<std::string> reasons = {"Not accepted: " + candidate.id};
  for (const ScreenedCandidate::Gate& gate : candidate.gates) {
    if (!gate.passed) reasons.push_back(gate.name + ": " + gate.advice);
  }
  if (!candidate.advice.empty())
    reasons.push_back(fmt::format("score: Q {:.2f}, needed {:g}. {}", candidate.score, screen.tau, candidate.advice));
  if (screen.audited && !screen.audit_passed) reasons.push_back(screen.reason);
  return reasons;
}

std::string write_best_video(const BestVideoOptions& options) {
  const ScreenRecord screen = load_screen(options.screen);
  if (screen.decision != "fail")
    throw invalid_field(options.screen, "/decision", screen.decision,
                        "\"fail\": nothing was accepted in the last round");
  SceneNeeds needs;
  needs.gaussians = needs.output_cameras = true;
  const Scene scene = load_scene(options.scene, needs);
  const State state = load_state(options.state);
  const Gaussians gaussians = load_labelled_gaussians(scene.gaussians, state, options.state);

  const std::vector<const ScreenedCandidate*> candidates = by_rank(screen);
  const auto whole = std::find_if(candidates.begin(), candidates.end(), [&](const ScreenedCandidate* c) {
    return !load_execution(join_path(options.rollouts, c->id + ".json")).diverged;
  });
  const ScreenedCandidate& best = whole == candidates.end() ? *candidates.front() : **whole;
  const std::vector<std::string> reasons = reasons_of(best, screen);

  const std::string best_rollout = join_path(options.rollouts, best.id + ".h5");
  const ExecutionRecord execution = load_execution_of(best_rollout);
  require_made_from(execution_path_of(best_rollout), options.state, false);
  const RolloutFrames rollout(best_rollout, state);
  const FittedCameras shown = video_cameras(scene, state, gaussians, rollout, execution, options.cameras);
  const Camera& first = shown.camera(0);
  Renderer renderer(gaussians);
  const RenderOptions render_options = video_options(scene.run.render);
  const std::string candidate = options.candidates.empty() ? "" : join_path(options.candidates, best.id + ".json");
  VideoPictures pictures(scene, state, gaussians, {options.scene, best_rollout, "", candidate, best.id});
  VideoWriter video(options.out, first.width, first.height, 1 / scene.run.time.frame_dt);
  const int frames = scene.run.time.frames;
  Progress progress("frame", frames);
  for (int t = 0; t < frames; ++t) {
    const Camera& camera = shown.camera(t);
    const int last = std::min(t, rollout.count() - 1);
    const TransportedFrame frame = rollout.frame(last);
    const RenderedImage& image = renderer.render(camera, frame.deformation(), render_options);
    Image picture = pictures.picture(image, quantize(image), frame, rollout.time(last), camera);
    write_caption(picture, reasons);
    video.write(picture);
    progress.update(t + 1);
  }
  video.finish();
  return best.id;
}

}  // namespace physmas::splat
