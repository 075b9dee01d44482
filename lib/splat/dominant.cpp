#include "splat/dominant.h"

#include <algorithm>
#include <cmath>

namespace physmas::splat {

std::vector<int> dominant_gaussians(const Gaussians& gaussians, const Deformation& deformation, const Camera& camera,
                                    double near, const std::vector<Eigen::Vector2i>& pixels) {
  const RowMatrix3f rest_F = RowMatrix3f::Identity();
  ProjectionSetup setup;
  setup.camera = camera;
  setup.near = near;
  const long n = static_cast<long>(gaussians.size());
  std::vector<Splat> splats(n);
  std::vector<uint8_t> drawn(n);
#pragma omp parallel for schedule(dynamic, 1024)
  for (long i = 0; i < n; ++i) {
    const Eigen::Vector3f& position = deformation.position ? deformation.position[i] : gaussians.position[i];
    const RowMatrix3f& F = deformation.F ? deformation.F[i] : rest_F;
    drawn[i] =
        project_gaussian(gaussians, i, rest_shape(gaussians, i), position, F, setup, &splats[i]) == Projection::drawn;
  }
  std::vector<int> order;
  for (long i = 0; i < n; ++i) {
    if (drawn[i] != 0) order.push_back(static_cast<int>(i));
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return splats[a].depth < splats[b].depth; });

  std::vector<int> dominant(pixels.size(), -1);
  for (size_t p = 0; p < pixels.size(); ++p) {
    const double x = pixels[p].x() + 0.5, y = pixels[p].y() + 0.5;
    double transmittance = 1, largest = 0;
    for (const int i : order) {
      const Splat& s = splats[i];
      const double dx = x - s.x, dy = y - s.y;
      if (std::fabs(dx) > s.half_x || std::fabs(dy) > s.half_y) continue;
      const double u = s.a * dx + s.b * dy, v = s.c * dy;
      const double alpha = std::min<double>(kMaxAlpha, std::exp2(s.log2_opacity) * std::exp(-0.5 * (u * u + v * v)));
      if (alpha < kMinAlpha) continue;
      if (transmittance * (1 - alpha) < kMinTransmittance) break;
      if (alpha * transmittance > largest) largest = alpha * transmittance, dominant[p] = i;
      transmittance *= 1 - alpha;
    }
  }
  return dominant;
}

}  // namespace physmas::splat
