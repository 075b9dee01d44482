#include "report/preview_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "bind/coarse_motion.h"
#include "lift/carriers.h"
#include "report/run_sections.h"
#include "splat/fitted_camera.h"
#include "splat/floor_shadow.h"
#include "splat/quantize.h"
#include "splat/renderer.h"
#include "splat/rollout_frames.h"
#include "splat/video_pictures.h"

namespace physmas::report {
namespace {

constexpr int kPictures = 21;           // at most
constexpr int kFewestPictures = 4;      // of a scene with many Gaussians
constexpr double kMostGaussians = 2e6;  // over all pictures, where these are more than kFewestPictures
constexpr int kSize = 400;              // pixels, the longer side of a picture

// Every Gaussian of the scene, carried by the particles of a coarse motion.
class CarriedFrames {
 public:
  CarriedFrames(const bind::CoarseMotion& motion, const State& state, const Gaussians& gaussians)
      : motion_(motion), map_(state.map) {
    std::vector<Eigen::Vector3f> means;
    for (const Eigen::Vector3f& mean : gaussians.position)
      means.push_back(state.map.to_solver(mean.cast<double>()).cast<float>());
    means.insert(means.end(), motion.rest.begin(), motion.rest.end());
    std::vector<int32_t> row = state.gaussian_row, chosen;
    row.insert(row.end(), motion.row.begin(), motion.row.end());
    for (size_t q = 0; q < motion.rest.size(); ++q) chosen.push_back(static_cast<int32_t>(gaussians.size() + q));
    carriers_ = lift::carry(means, row, chosen);
  }
  splat::TransportedFrame frame(int t) const { return {motion_.frames[static_cast<size_t>(t)], map_, carriers_}; }

 private:
  const bind::CoarseMotion& motion_;
  const SolverMap& map_;
  Carriers carriers_;
};

Camera smaller(Camera camera) {
  const double scale = static_cast<double>(kSize) / std::max(camera.width, camera.height);
  camera.fx *= scale, camera.fy *= scale, camera.cx *= scale, camera.cy *= scale;
  camera.width = std::max(1, static_cast<int>(std::lround(camera.width * scale)));
  camera.height = std::max(1, static_cast<int>(std::lround(camera.height * scale)));
  return camera;
}

std::string roughness_text(const bind::CoarseMotion& motion, const Candidate& candidate, int cells) {
  std::string text = fmt::format(
      "The candidate {} on {} cells along each edge in place of {}: roughly what will be, "
      "without contacts and shapes that are smaller than a cell.",
      plain_id(candidate.id), motion.cells, cells);
  if (motion.reason == "budget")
    text += fmt::format(" Shown are the first {:.2g} of {:.2g} s: these materials are too stiff for a quick look.",
                        motion.times.back(), motion.asked);
  else if (!motion.reason.empty())
    text += fmt::format(" On so few cells it does not hold longer than {:.2g} of {:.2g} s.", motion.times.back(),
                        motion.asked);
  return text;
}

}  // namespace

PreviewMotion preview_motion(const RunRecords& run, const Scene& scene, const Gaussians& gaussians) {
  PreviewMotion shown;
  std::vector<const Candidate*> candidates;
  for (const RunRecords::Attempt& attempt : run.attempts) {
    if (attempt.candidate.round == 0) candidates.push_back(&attempt.candidate);
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto* a, const auto* b) { return a->order < b->order; });
  if (candidates.empty() || !run.state) {
    shown.why_not = "there is no candidate yet";
    return shown;
  }
  const RunSpecification specification = load_scene(run.path("spec/simulate.json"), {}).run;
  const int pictures =
      std::clamp(static_cast<int>(kMostGaussians / static_cast<double>(std::max<size_t>(1, gaussians.size()))),
                 kFewestPictures, kPictures);
  bind::CoarseMotion motion;
  const Candidate* moved = nullptr;
  const auto attempt = [&](const Candidate& candidate, bool adaptive) {
    motion = bind::coarse_motion(candidate, *run.state, specification,
                                 {run.path("state.h5"), run.path("candidates/" + candidate.id + ".json")}, pictures,
                                 adaptive);
    if (motion.frames.size() > 1) moved = &candidate;
  };
  for (const Candidate* candidate : candidates) {
    if (moved == nullptr) attempt(*candidate, false);
  }
  // Where none holds with its own steps, a run would go back to steps that follow the state.
  if (moved == nullptr) attempt(*candidates.front(), true);
  if (moved == nullptr) {
    shown.why_not = "on few cells it cannot be followed: its materials are too stiff, or it does not hold together";
    return shown;
  }

  const int count = static_cast<int>(motion.frames.size());
  const CarriedFrames frames(motion, *run.state, gaussians);
  const std::vector<Camera> base = {smaller(scene.output_cameras.front())};
  FittedCameras fitted;
  fitted.cameras = base;
  if (scene.run.render.camera_mode() != RunSpecification::Render::CameraMode::fixed) {
    splat::add_motion(
        gaussians, *run.state, count, [&](int t) { return frames.frame(t); }, base, fitted);
    splat::place_cameras(gaussians, base, fitted);
  }
  splat::Renderer renderer(gaussians);
  const splat::RenderOptions options = splat::video_options(scene.run.render);
  std::unique_ptr<splat::FloorShadow> floor;
  if (scene.run.render.has_floor())
    floor = std::make_unique<splat::FloorShadow>(gaussians, splat::floor_plane(scene.run, run.state->map, gaussians),
                                                 options.background);
  for (int t = 0; t < count; ++t) {
    const splat::TransportedFrame frame = frames.frame(t);
    const splat::RenderedImage& image = renderer.render(fitted.camera(0), frame.deformation(), options);
    if (floor) floor->update(frame.deformation());
    shown.pictures.push_back(floor ? floor->picture(image, fitted.camera(0)) : splat::quantize(image));
    shown.times.push_back(motion.times[static_cast<size_t>(t)]);
  }
  shown.about = roughness_text(motion, *moved, specification.grid.n);
  return shown;
}

}  // namespace physmas::report
