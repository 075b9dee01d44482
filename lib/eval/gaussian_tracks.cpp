#include "eval/gaussian_tracks.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "records/plan.h"
#include "splat/renderer.h"
#include "splat/transport.h"

namespace physmas::eval {
namespace {

// Pixels where the target's Gaussians outweigh all others in an opaque enough pixel.
constexpr float kSilhouetteAlpha = 0.5f;

class TargetRenderer {
 public:
  TargetRenderer(const Scene& scene, const Gaussians& gaussians, const SolverMap& map,
                 const std::vector<uint8_t>& target)
      : scene_(scene), map_(map), renderer_(gaussians), labels_(target.begin(), target.end()) {}

  // Mask of the target in frame t, 0 or 255.
  Image silhouette(const splat::TransportedFrame& frame, int t) { return mask_of(render(frame, t, labels_)); }

  // Index of the dominant Gaussian per pixel.
  std::vector<int32_t> dominant(const splat::TransportedFrame& frame, int t) {
    std::vector<int32_t> indices(labels_.size());
    std::iota(indices.begin(), indices.end(), 0);
    return render(frame, t, indices).label;
  }

 private:
  const splat::RenderedImage& render(const splat::TransportedFrame& frame, int t, const std::vector<int32_t>& labels) {
    splat::RenderOptions options;
    options.labels = labels.data();
    options.label = true;
    options.max_sh_degree = 0;
    return renderer_.render(scene_.output_camera(t), frame.deformation(), options);
  }
  static Image mask_of(const splat::RenderedImage& image) {
    Image mask(image.width, image.height, 1);
    for (size_t p = 0; p < image.alpha.size(); ++p)
      mask.pixels[p] = image.alpha[p] >= kSilhouetteAlpha && image.label[p] == 1 ? 255 : 0;
    return mask;
  }

  const Scene& scene_;
  const SolverMap& map_;
  splat::Renderer renderer_;
  std::vector<int32_t> labels_;
};

}  // namespace

std::vector<int> choose_queries(const Scene& scene, const Gaussians& gaussians, const State& state,
                                const RolloutReader& rollout, const std::vector<uint8_t>& target) {
  TargetRenderer renderer(scene, gaussians, state.map, target);
  const splat::TransportedFrame frame(rollout.frame(0), state.map);
  const Image mask = renderer.silhouette(frame, 0);
  const std::vector<int32_t> dominant = renderer.dominant(frame, 0);
  std::vector<int> queries;
  for (const QueryPixel& q : query_pixels(mask)) {
    const int32_t gaussian = dominant[static_cast<size_t>(q.y) * mask.width + q.x];
    if (gaussian >= 0 && target[gaussian] != 0 && std::find(queries.begin(), queries.end(), gaussian) == queries.end())
      queries.push_back(gaussian);
  }
  return queries;
}

TargetMotion track_target(const Scene& scene, const Gaussians& gaussians, const State& state,
                          const RolloutReader& rollout, const std::vector<uint8_t>& target,
                          const std::vector<int>& queries) {
  TargetRenderer renderer(scene, gaussians, state.map, target);
  TargetMotion motion;
  motion.tracks.width = scene.output_camera(0).width;
  motion.tracks.height = scene.output_camera(0).height;
  for (int t = 0; t < rollout.frame_count(); ++t) {
    const Camera& camera = scene.output_camera(t);
    const splat::TransportedFrame frame(rollout.frame(t), state.map);
    const Image mask = renderer.silhouette(frame, t);
    motion.areas.push_back(mask_areas({mask}).front());
    std::vector<Eigen::Vector2d> position;
    std::vector<uint8_t> visible;
    for (int gaussian : queries) {
      const Eigen::Vector3d q = camera.to_camera(frame.position(gaussian).cast<double>());
      const Eigen::Vector2d u = q.z() > 0 ? camera.project(q) : Eigen::Vector2d(-1, -1);
      const bool inside = u.allFinite() && u.x() >= 0 && u.y() >= 0 && u.x() < mask.width && u.y() < mask.height;
      position.push_back(u);
      visible.push_back(inside && *mask.at(static_cast<int>(u.x()), static_cast<int>(u.y())) != 0 ? 1 : 0);
    }
    motion.tracks.position.push_back(std::move(position));
    motion.tracks.visible.push_back(std::move(visible));
  }
  return motion;
}

std::vector<uint8_t> target_gaussians(const Inventory& inventory, const State& state, const std::string& target) {
  const std::vector<int> rows = resolve_rows(inventory, target);
  if (!target.empty() && rows.empty()) {
    std::string known;
    for (const InventoryObject& object : inventory.objects) known += (known.empty() ? "" : ", ") + object.id;
    throw Error(ExitCode::usage,
                fmt::format("--target: found \"{}\", expected an object ({}) or a row key object/part", target, known));
  }
  std::vector<uint8_t> mask(state.gaussian_count(), target.empty() ? 1 : 0);
  for (size_t i = 0; i < mask.size(); ++i) {
    for (int row : rows) {
      if (state.gaussian_row[i] == row) mask[i] = 1;
    }
  }
  return mask;
}

std::vector<Image> target_silhouettes(const Scene& scene, const Gaussians& gaussians, const State& state,
                                      const RolloutReader& rollout, const std::vector<uint8_t>& target) {
  TargetRenderer renderer(scene, gaussians, state.map, target);
  std::vector<Image> masks;
  for (int t = 0; t < rollout.frame_count(); ++t)
    masks.push_back(renderer.silhouette(splat::TransportedFrame(rollout.frame(t), state.map), t));
  return masks;
}

}  // namespace physmas::eval
