#include "splat/image_plane.h"

#include <algorithm>
#include <cmath>

namespace physmas::splat {
namespace {

constexpr double kPlanePixels = 1 << 24;
constexpr float kOpaque = 0.5f;
constexpr long kFew = 1000;  // one in so many

}  // namespace

Window intersection(const Window& a, const Window& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

Window around_picture(const Camera& camera, int pictures) {
  return {-pictures * camera.width, -pictures * camera.height, (pictures + 1) * camera.width,
          (pictures + 1) * camera.height};
}

bool too_large(const Window& window, const Window& picture) {
  return window.pixels() > std::max(kPlanePixels, 9 * picture.pixels());
}

Camera camera_of(const Camera& camera, const Window& window) {
  Camera moved = camera;
  moved.width = window.x1 - window.x0;
  moved.height = window.y1 - window.y0;
  moved.cx -= window.x0;
  moved.cy -= window.y0;
  return moved;
}

Window reach_of_splats(const Gaussians& gaussians, const TransportedFrame& frame, const Camera& camera, double near) {
  const Window far = around_picture(camera, kFarPictures);
  ProjectionSetup setup;
  setup.camera = camera_of(camera, far);
  setup.near = near;
  double x0 = far.x1, y0 = far.y1, x1 = far.x0, y1 = far.y0;
  const long n = static_cast<long>(gaussians.size());
#pragma omp parallel for schedule(static) reduction(min : x0, y0) reduction(max : x1, y1)
  for (long i = 0; i < n; ++i) {
    Splat splat;
    const RestShape rest = rest_shape(gaussians, i);
    if (project_gaussian(gaussians, i, rest, frame.position(i), frame.F(i), setup, &splat) != Projection::drawn)
      continue;
    const double x = splat.x + far.x0, y = splat.y + far.y0;
    x0 = std::min(x0, x - splat.half_x), x1 = std::max(x1, x + splat.half_x);
    y0 = std::min(y0, y - splat.half_y), y1 = std::max(y1, y + splat.half_y);
  }
  if (x0 >= x1) return {};
  return {static_cast<int>(std::floor(std::max<double>(x0, far.x0))),
          static_cast<int>(std::floor(std::max<double>(y0, far.y0))),
          static_cast<int>(std::ceil(std::min<double>(x1, far.x1))),
          static_cast<int>(std::ceil(std::min<double>(y1, far.y1)))};
}

Window at_tiles(const Window& window) {
  const auto down = [](int v) { return (v >= 0 ? v : v - kTileSize + 1) / kTileSize * kTileSize; };
  return {down(window.x0), down(window.y0), down(window.x1 + kTileSize - 1), down(window.y1 + kTileSize - 1)};
}

Behind went_behind(const Gaussians& gaussians, const TransportedFrame& first, const TransportedFrame& last,
                   const Camera& camera, double near) {
  const Window far = around_picture(camera, kFarPictures);
  long counted = 0;
  Behind behind;
  double x0 = far.x1, y0 = far.y1, x1 = far.x0, y1 = far.y0;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    if (!(gaussians.opacity(i) >= kOpaque)) continue;
    const Eigen::Vector3d before = camera.to_camera(first.position(i).cast<double>());
    const Eigen::Vector3d after = camera.to_camera(last.position(i).cast<double>());
    if (!(before.z() > near)) continue;
    ++counted;
    if (!after.allFinite() || after.z() > near) continue;
    ++behind.count;
    const Eigen::Vector2d u = camera.project({after.x(), after.y(), near});
    const double x = std::clamp<double>(u.x(), far.x0, far.x1 - 1), y = std::clamp<double>(u.y(), far.y0, far.y1 - 1);
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  if (behind.count * kFew <= counted) return {};
  behind.window = {static_cast<int>(std::floor(x0)), static_cast<int>(std::floor(y0)),
                   static_cast<int>(std::floor(x1)) + 1, static_cast<int>(std::floor(y1)) + 1};
  return behind;
}

}  // namespace physmas::splat
