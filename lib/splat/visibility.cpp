#include "splat/visibility.h"

#include "scene/color.h"
#include "splat/renderer.h"

namespace physmas::splat {
namespace {

constexpr double kSlack = 0.25;       // of the renderer's default near plane, a hundredth of the scene
constexpr float kTranslucent = 0.5f;  // opacity below which a Gaussian cannot decide its pixel alone
constexpr float kOtherColor = 0.08f;  // difference of chromaticity beyond which a pixel shows something else
constexpr float kDark = 0.3f;         // largest channel of a colour whose chromaticity says little

// Whether the pixel's colour, over black, is another one than the Gaussian's.
bool shows_something_else(const RenderedImage& image, int32_t pixel, const Eigen::Vector3f& color) {
  const Eigen::Vector3f shown = Eigen::Vector3f::Map(&image.rgb[3 * static_cast<size_t>(pixel)]) / image.alpha[pixel];
  if (shown.maxCoeff() < kDark || color.maxCoeff() < kDark) return false;
  return (chromaticity(shown) - chromaticity(color)).norm() > kOtherColor;
}

}  // namespace

std::vector<int32_t> project_to_pixels(const std::vector<Eigen::Vector3f>& means, const Camera& camera) {
  std::vector<int32_t> pixel(means.size(), -1);
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < means.size(); ++i) {
    const Eigen::Vector3d q = camera.to_camera(means[i].cast<double>());
    if (!(q.z() > 0)) continue;
    const Eigen::Vector2d u = camera.project(q);
    // Pixel i covers [i, i + 1).
    if (!(u.x() >= 0 && u.x() < camera.width && u.y() >= 0 && u.y() < camera.height)) continue;
    pixel[i] = static_cast<int32_t>(u.y()) * camera.width + static_cast<int32_t>(u.x());
  }
  return pixel;
}

double depth_slack(const Gaussians& gaussians, size_t i, const Eigen::Vector3f& position, const Eigen::Matrix3f& F,
                   const Camera& camera, double default_near, double deviations) {
  const Eigen::Vector3f ray = (position - camera.center().cast<float>()).normalized();
  // Sigma = F R S S R^T F^T along the ray.
  const Eigen::Vector3f along =
      gaussians.scale(i).asDiagonal() * (gaussians.rotation_matrix(i).transpose() * (F.transpose() * ray));
  return kSlack * default_near + deviations * along.norm();
}

std::vector<std::vector<uint8_t>> visible_in_views(const Gaussians& gaussians, const std::vector<Camera>& cameras) {
  Renderer renderer(gaussians);
  RenderOptions options;
  options.max_sh_degree = 0;
  options.depth = true;
  std::vector<std::vector<uint8_t>> visible;
  for (const Camera& camera : cameras) {
    const std::vector<int32_t> pixels = project_to_pixels(gaussians.position, camera);
    const RenderedImage& image = renderer.render(camera, {}, options);
    std::vector<uint8_t> seen(gaussians.size(), 0);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < gaussians.size(); ++i) {
      if (pixels[i] < 0) continue;
      const double depth = camera.to_camera(gaussians.position[i].cast<double>()).z();
      const double slack = depth_slack(gaussians, i, gaussians.position[i], Eigen::Matrix3f::Identity(), camera,
                                       renderer.default_near(), 1);
      const float surface = image.depth[pixels[i]];
      seen[i] = surface <= 0 || depth <= surface + slack;
      if (seen[i] != 0 && surface > 0 && gaussians.opacity(i) < kTranslucent)
        seen[i] = !shows_something_else(image, pixels[i], gaussians.base_color(i));
    }
    visible.push_back(std::move(seen));
  }
  return visible;
}

}  // namespace physmas::splat
