#include "bundle/distortion.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace physmas::bundle {
namespace {

// What `pixel` shows, at distance 1.
Eigen::Vector2d ray(const Camera& camera, double x, double y) {
  return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy};
}

// Determinant of the derivative of Distortion::distorted.
double stretch(const Distortion& d, const Eigen::Vector2d& p) {
  constexpr double h = 1e-5;
  const Eigen::Vector2d dx = d.distorted(p + Eigen::Vector2d(h, 0)) - d.distorted(p - Eigen::Vector2d(h, 0)),
                        dy = d.distorted(p + Eigen::Vector2d(0, h)) - d.distorted(p - Eigen::Vector2d(0, h));
  return (dx.x() * dy.y() - dx.y() * dy.x()) / (4 * h * h);
}

}  // namespace

Eigen::Vector2d Distortion::distorted(const Eigen::Vector2d& p) const {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

void require_unfolded(const Distortion& distortion, const Camera& camera, const std::string& file,
                      const std::string& field) {
  if (distortion.none()) return;
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d p = ray(camera, double(i) / kSteps * camera.width, double(j) / kSteps * camera.height);
      if (stretch(distortion, p) > 0 && distortion.distorted(p).dot(p) >= 0) continue;
      throw invalid_input({file, field, "a distortion that folds the image over", "one that a picture can be freed of",
                           "undistort the images first, for example with COLMAP's image_undistorter"});
    }
  }
}

Image undistorted(const Image& image, const Camera& camera, const Distortion& distortion) {
  Image out(image.width, image.height, image.channels);
  const double right = image.width - 1, bottom = image.height - 1;
#pragma omp parallel for
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const Eigen::Vector2d p = distortion.distorted(ray(camera, x + 0.5, y + 0.5));
      // From here on pixel centres are whole numbers.
      const double u = std::clamp(camera.fx * p.x() + camera.cx - 0.5, 0.0, right),
                   v = std::clamp(camera.fy * p.y() + camera.cy - 0.5, 0.0, bottom);
      const int left = static_cast<int>(u), top = static_cast<int>(v);
      const double a = u - left, b = v - top;
      const uint8_t *p00 = image.at(left, top), *p10 = image.at(std::min(left + 1, image.width - 1), top),
                    *p01 = image.at(left, std::min(top + 1, image.height - 1)),
                    *p11 = image.at(std::min(left + 1, image.width - 1), std::min(top + 1, image.height - 1));
      for (int c = 0; c < image.channels; ++c) {
        const double value = (1 - b) * ((1 - a) * p00[c] + a * p10[c]) + b * ((1 - a) * p01[c] + a * p11[c]);
        out.at(x, y)[c] = static_cast<uint8_t>(std::lround(value));
      }
    }
  }
  return out;
}

}  // namespace physmas::bundle
