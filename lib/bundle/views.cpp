#include "bundle/views.h"

#include <algorithm>

#include "splat/quantize.h"
#include "splat/renderer.h"

namespace physmas::bundle {

std::vector<Image> render_view_images(const Gaussians& gaussians, const std::vector<Camera>& cameras,
                                      const RunSpecification::Render& render) {
  splat::Renderer renderer(gaussians);
  splat::RenderOptions options;
  options.background = render.background.cast<float>();
  options.max_sh_degree = render.sh_degree;
  options.max_pairs = size_t{1} << 22;  // 16 MiB: a scene of millions takes enough by itself
  std::vector<Image> images;
  for (const Camera& camera : cameras) {
    const splat::RenderedImage& rendered = renderer.render(camera, {}, options);
    const Image rgb = splat::quantize(rendered);
    Image rgba(rgb.width, rgb.height, 4);
    for (size_t i = 0; i < rendered.alpha.size(); ++i) {
      std::copy_n(&rgb.pixels[3 * i], 3, &rgba.pixels[4 * i]);
      rgba.pixels[4 * i + 3] = static_cast<uint8_t>(std::clamp(rendered.alpha[i], 0.0f, 1.0f) * 255 + 0.5f);
    }
    images.push_back(std::move(rgba));
  }
  return images;
}

}  // namespace physmas::bundle
