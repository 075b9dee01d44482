#include "scene/color.h"

#include <cmath>

namespace physmas {
namespace {

double linear_of_srgb(double c) {
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double lab_curve(double t) {
  constexpr double kDelta = 6.0 / 29.0;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29.0;
}

}  // namespace

Eigen::Vector3d lab_of_srgb(const Eigen::Vector3d& srgb) {
  const Eigen::Vector3d c = srgb.unaryExpr(&linear_of_srgb);
  const double x = lab_curve((0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2]) / 0.95047);
  const double y = lab_curve(0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2]);
  const double z = lab_curve((0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2]) / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Eigen::Vector3f chromaticity(const Eigen::Vector3f& srgb) {
  const Eigen::Vector3f cut = srgb.cwiseMax(0.02f).cwiseMin(1.0f);
  return cut / cut.sum();
}

}  // namespace physmas
