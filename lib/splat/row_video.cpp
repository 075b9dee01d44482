#include "splat/row_video.h"

#include "splat/quantize.h"
#include "splat/row_colors.h"

namespace physmas::splat {

RowVideo::RowVideo(const std::string& path, const Gaussians& gaussians, const std::vector<int32_t>& row,
                   const std::vector<bool>& residual, int width, int height, double fps)
    : painted_(painted_by_row(gaussians, row, residual)), renderer_(painted_), video_(path, width, height, fps) {}

void RowVideo::add(const Camera& camera, const Deformation& deformation) {
  RenderOptions options;
  options.background = Eigen::Vector3f::Ones();
  video_.write(quantize(renderer_.render(camera, deformation, options)));
}

}  // namespace physmas::splat
