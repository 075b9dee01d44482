#include "metrics/gaussian_tracks.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "records/plan.h"
#include "splat/dominant.h"
#include "splat/renderer.h"
#include "splat/visibility.h"

namespace physmas::metrics {
namespace {

// Pixels where the target's Gaussians outweigh all others in an opaque enough pixel.
constexpr float kSilhouetteAlpha = 0.5f;
// Splats are blended by the depth of their means: on a tilted surface those within reach of each other's extent cover
// what lies level with them.
constexpr double kDeviations = 3;

class TargetRenderer {
 public:
  TargetRenderer(const Scene& scene, const Gaussians& gaussians, const std::vector<uint8_t>& target)
      : scene_(scene), renderer_(gaussians), labels_(target.begin(), target.end()) {}

  // Renders frame t with all Gaussians; what follows speaks of that frame until the next call.
  void render(const splat::TransportedFrame& frame, int t) {
    splat::RenderOptions options;
    options.labels = labels_.data();
    options.label = options.depth = true;
    options.max_sh_degree = 0;
    image_ = &renderer_.render(scene_.output_camera(t), frame.deformation(), options);
  }

  // Mask of the target, 0 or 255.
  Image silhouette() const {
    Image mask(image_->width, image_->height, 1);
    for (size_t p = 0; p < image_->alpha.size(); ++p) mask.pixels[p] = in_silhouette(p) ? 255 : 0;
    return mask;
  }

  // How much deeper than the rendered depth a mean at camera depth `depth` lies that projects to u, scene units.
  // Nothing where that is outside the silhouette.
  std::optional<double> behind_surface(const Eigen::Vector2d& u, double depth) const {
    if (!(u.x() >= 0 && u.y() >= 0 && u.x() < image_->width && u.y() < image_->height)) return std::nullopt;
    const size_t p = static_cast<size_t>(u.y()) * image_->width + static_cast<size_t>(u.x());
    return in_silhouette(p) ? std::optional<double>(depth - image_->depth[p]) : std::nullopt;
  }

  double near() const { return renderer_.default_near(); }

 private:
  bool in_silhouette(size_t p) const { return image_->alpha[p] >= kSilhouetteAlpha && image_->label[p] == 1; }

  const Scene& scene_;
  splat::Renderer renderer_;
  std::vector<int32_t> labels_;
  const splat::RenderedImage* image_ = nullptr;  // the renderer's
};

}  // namespace

std::vector<int> choose_queries(const Scene& scene, const Gaussians& gaussians, const splat::RolloutFrames& rollout,
                                const std::vector<uint8_t>& target) {
  TargetRenderer renderer(scene, gaussians, target);
  const splat::TransportedFrame frame = rollout.frame(0);
  renderer.render(frame, 0);
  const Image mask = renderer.silhouette();
  std::vector<Eigen::Vector2i> pixels;
  for (const QueryPixel& q : query_pixels(mask)) pixels.emplace_back(q.x, q.y);
  std::vector<int> queries;
  for (const int gaussian :
       splat::dominant_gaussians(gaussians, frame.deformation(), scene.output_camera(0), renderer.near(), pixels)) {
    if (gaussian >= 0 && target[gaussian] != 0 && std::find(queries.begin(), queries.end(), gaussian) == queries.end())
      queries.push_back(gaussian);
  }
  return queries;
}

TargetMotion track_target(const Scene& scene, const Gaussians& gaussians, const splat::RolloutFrames& rollout,
                          const std::vector<uint8_t>& target, const std::vector<int>& queries) {
  TargetRenderer renderer(scene, gaussians, target);
  TargetMotion motion;
  motion.tracks.width = scene.output_camera(0).width;
  motion.tracks.height = scene.output_camera(0).height;
  std::vector<double> first(queries.size(), 0);  // how far behind the surface in frame 0, if at all
  for (int t = 0; t < rollout.count(); ++t) {
    const Camera& camera = scene.output_camera(t);
    const splat::TransportedFrame frame = rollout.frame(t);
    renderer.render(frame, t);
    motion.areas.push_back(mask_areas({renderer.silhouette()}).front());
    std::vector<Eigen::Vector2d> position;
    std::vector<uint8_t> visible;
    for (size_t k = 0; k < queries.size(); ++k) {
      const Eigen::Vector3f& mean = frame.position(queries[k]);
      const Eigen::Vector3d q = camera.to_camera(mean.cast<double>());
      const Eigen::Vector2d u = q.z() > 0 ? camera.project(q) : Eigen::Vector2d(-1, -1);
      const std::optional<double> behind = renderer.behind_surface(u, q.z());
      if (t == 0 && behind) first[k] = std::max(0.0, *behind);
      position.push_back(u);
      visible.push_back(behind && *behind <= first[k] + splat::depth_slack(gaussians, queries[k], mean,
                                                                           frame.F(queries[k]), camera, renderer.near(),
                                                                           kDeviations)
                            ? 1
                            : 0);
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

std::vector<Image> target_silhouettes(const Scene& scene, const Gaussians& gaussians,
                                      const splat::RolloutFrames& rollout, const std::vector<uint8_t>& target) {
  TargetRenderer renderer(scene, gaussians, target);
  std::vector<Image> masks;
  for (int t = 0; t < rollout.count(); ++t) {
    renderer.render(rollout.frame(t), t);
    masks.push_back(renderer.silhouette());
  }
  return masks;
}

}  // namespace physmas::metrics
