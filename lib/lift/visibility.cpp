#include "lift/visibility.h"

#include "lift/evidence.h"
#include "splat/renderer.h"

namespace physmas::lift {
namespace {

constexpr double kSlack = 0.25;  // of the renderer's default near plane, a hundredth of the scene

}  // namespace

std::vector<std::vector<uint8_t>> visible_in_views(const Gaussians& gaussians, const std::vector<Camera>& cameras) {
  splat::Renderer renderer(gaussians);
  splat::RenderOptions options;
  options.max_sh_degree = 0;
  options.depth = true;
  std::vector<std::vector<uint8_t>> visible;
  for (const Camera& camera : cameras) {
    const std::vector<int32_t> pixels = project_to_pixels(gaussians.position, camera);
    const splat::RenderedImage& image = renderer.render(camera, {}, options);
    std::vector<uint8_t> seen(gaussians.size(), 0);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < gaussians.size(); ++i) {
      if (pixels[i] < 0) continue;
      const double depth = camera.to_camera(gaussians.position[i].cast<double>()).z();
      const double slack = kSlack * renderer.default_near() + gaussians.scale(i).maxCoeff();
      const float surface = image.depth[pixels[i]];
      seen[i] = surface <= 0 || depth <= surface + slack;
    }
    visible.push_back(std::move(seen));
  }
  return visible;
}

}  // namespace physmas::lift
