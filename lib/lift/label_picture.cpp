#include "lift/label_picture.h"

#include "scene/image_file.h"
#include "splat/quantize.h"
#include "splat/renderer.h"
#include "splat/row_colors.h"

namespace physmas::lift {

Image label_picture(const Gaussians& gaussians, const std::vector<int32_t>& row, const std::vector<bool>& residual,
                    const Camera& camera) {
  const Gaussians painted = splat::painted_by_row(gaussians, row, residual);
  splat::Renderer renderer(painted);
  splat::RenderOptions options;
  options.background = Eigen::Vector3f::Ones();
  return splat::quantize(renderer.render(camera, {}, options));
}

}  // namespace physmas::lift
