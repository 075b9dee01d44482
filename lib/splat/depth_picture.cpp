#include "splat/depth_picture.h"

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "scene/image_file.h"

namespace physmas::splat {
namespace {

constexpr double kLevels = 65535;

}  // namespace

double depth_unit(const std::vector<Camera>& cameras, const SolverMap& map) {
  double farthest = 0;
  for (const Camera& camera : cameras) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d solver = map.length * Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2);
      farthest = std::max(farthest, camera.to_camera(map.to_scene(solver)).z());
    }
  }
  return farthest > 0 ? farthest / kLevels : 1;
}

bool save_depth_png(const std::string& path, const RenderedImage& image, double unit) {
  std::vector<uint16_t> levels(image.depth.size());
  for (size_t p = 0; p < levels.size(); ++p) {
    const double level = std::clamp(std::round(image.depth[p] / unit), 1.0, kLevels);
    levels[p] = image.depth[p] > 0 ? static_cast<uint16_t>(level) : 0;
  }
  return write_file(path, encode_png(image.width, image.height, levels));
}

}  // namespace physmas::splat
