#include "splat/video_pictures.h"

#include "base/error.h"
#include "records/candidate.h"
#include "records/execution.h"
#include "records/provenance.h"

namespace physmas::splat {
namespace {

std::unique_ptr<FloorShadow> make_floor(const Scene& scene, const State& state, const Gaussians& gaussians,
                                        const PictureSettings& settings) {
  const RunSpecification::Render& render = scene.run.render;
  if (settings.floor.empty() ? !render.has_floor() : settings.floor == "none") return nullptr;
  if (!scene.slice.empty() && !render.has_floor()) {
    throw invalid_input({settings.scene, "/run/colliders", "a slice of a run without render.floor=shadow",
                         "scene.json, or a slice that has them"});
  }
  return std::make_unique<FloorShadow>(gaussians, floor_plane(scene.run, state.map, gaussians),
                                       render.background.cast<float>());
}

std::unique_ptr<ActionSigns> make_signs(const Scene& scene, const State& state, const Gaussians& gaussians,
                                        const PictureSettings& settings) {
  if (!scene.run.render.shows_agents()) return nullptr;
  if (settings.candidate.empty()) {
    throw Error(ExitCode::usage, "--candidate is required where the run specification has render.agents: true");
  }
  const Candidate candidate = load_candidate(settings.candidate);
  require_made_from(execution_path_of(settings.rollout), settings.candidate, false);
  if (candidate.id != settings.id)
    throw invalid_input({settings.candidate, "/id", candidate.id, settings.id + ", whose rollout is rendered"});
  return std::make_unique<ActionSigns>(candidate, state, gaussians, scene.run.placement.up_vector());
}

}  // namespace

RenderOptions video_options(const RunSpecification::Render& render) {
  RenderOptions options;
  options.background = render.background.cast<float>();
  options.max_sh_degree = render.sh_degree;
  return options;
}

VideoPictures::VideoPictures(const Scene& scene, const State& state, const Gaussians& gaussians,
                             const PictureSettings& settings)
    : floor_(make_floor(scene, state, gaussians, settings)), signs_(make_signs(scene, state, gaussians, settings)) {}

Image VideoPictures::picture(const RenderedImage& image, const Image& quantized, const TransportedFrame& frame,
                             double time, const Camera& camera) {
  if (floor_) floor_->update(frame.deformation());
  Image picture = floor_ ? floor_->picture(image, camera) : quantized;
  if (signs_) signs_->draw(frame, time, camera, picture);
  return picture;
}

}  // namespace physmas::splat
