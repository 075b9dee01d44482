#include "eval/gaussian_tracks.h"

#include <numeric>
#include <opencv2/imgproc.hpp>

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

  // 8-bit mask of the target in frame t.
  cv::Mat silhouette(const splat::TransportedFrame& frame, int t) { return mask_of(render(frame, t, labels_)); }

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
  static cv::Mat mask_of(const splat::RenderedImage& image) {
    cv::Mat mask(image.height, image.width, CV_8U, cv::Scalar(0));
    for (size_t p = 0; p < image.alpha.size(); ++p)
      mask.data[p] = image.alpha[p] >= kSilhouetteAlpha && image.label[p] == 1 ? 255 : 0;
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
  cv::Mat mask = renderer.silhouette(frame, 0);
  cv::erode(mask, mask, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}), {-1, -1}, 1, cv::BORDER_CONSTANT,
            cv::Scalar(0));
  const std::vector<int32_t> dominant = renderer.dominant(frame, 0);
  std::vector<int> queries;
  for (int gy = 0; gy < kGrid; ++gy) {
    for (int gx = 0; gx < kGrid; ++gx) {
      const int x = static_cast<int>((gx + 0.5) * mask.cols / kGrid),
                y = static_cast<int>((gy + 0.5) * mask.rows / kGrid);
      if (mask.at<uint8_t>(y, x) == 0) continue;
      const int32_t gaussian = dominant[static_cast<size_t>(y) * mask.cols + x];
      if (gaussian >= 0 && target[gaussian] != 0) queries.push_back(gaussian);
    }
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
    const cv::Mat mask = renderer.silhouette(frame, t);
    motion.areas.push_back(cv::countNonZero(mask));
    std::vector<Eigen::Vector2d> position;
    std::vector<uint8_t> visible;
    for (int gaussian : queries) {
      const Eigen::Vector3d q = camera.to_camera(frame.position(gaussian).cast<double>());
      const Eigen::Vector2d u = q.z() > 0 ? camera.project(q) : Eigen::Vector2d(-1, -1);
      const bool inside = u.allFinite() && u.x() >= 0 && u.y() >= 0 && u.x() < mask.cols && u.y() < mask.rows;
      position.push_back(u);
      visible.push_back(inside && mask.at<uint8_t>(static_cast<int>(u.y()), static_cast<int>(u.x())) != 0 ? 1 : 0);
    }
    motion.tracks.position.push_back(std::move(position));
    motion.tracks.visible.push_back(std::move(visible));
  }
  return motion;
}

}  // namespace physmas::eval
