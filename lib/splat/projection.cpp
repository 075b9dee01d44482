#include "splat/projection.h"

#include <algorithm>
#include <cmath>

#include "splat/polar.h"
#include "splat/sh.h"

namespace physmas::splat {
namespace {

// Larger standard deviations look the same, and their products would overflow.
constexpr float kMaxLogScale = 69;  // 1e30 scene units

}  // namespace

bool ProjectionSetup::operator==(const ProjectionSetup& o) const {
  const Camera &a = camera, &b = o.camera;
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.world_to_camera == b.world_to_camera && near == o.near && sh_degree == o.sh_degree;
}

RestShape rest_shape(const Gaussians& g, size_t i) {
  const Eigen::Vector3f scale = g.log_scale[i].cwiseMin(kMaxLogScale).array().exp();
  return {g.rotation_matrix(i) * scale.asDiagonal(), g.opacity(i)};
}

Projection project_gaussian(const Gaussians& g, size_t i, const RestShape& rest, const Eigen::Vector3f& position,
                            const RowMatrix3f& F, const ProjectionSetup& setup, Splat* splat) {
  const Camera& camera = setup.camera;
  if (!position.allFinite() || !F.allFinite()) return Projection::not_finite;
  if (!(rest.opacity >= kMinAlpha)) return Projection::hidden;
  const Eigen::Vector3d mean = position.cast<double>();
  const Eigen::Vector3d t = camera.to_camera(mean);
  if (!(t.z() > setup.near)) return Projection::hidden;

  // The Jacobian of the projection; outside the guard band its linearisation would blow up, so it is frozen there.
  const double inverse_z = 1 / t.z();
  const double margin_x = kGuard * 0.5 * camera.width / camera.fx, margin_y = kGuard * 0.5 * camera.height / camera.fy;
  const double tan_x = std::clamp(t.x() * inverse_z, -camera.cx / camera.fx - margin_x,
                                  (camera.width - camera.cx) / camera.fx + margin_x);
  const double tan_y = std::clamp(t.y() * inverse_z, -camera.cy / camera.fy - margin_y,
                                  (camera.height - camera.cy) / camera.fy + margin_y);
  Eigen::Matrix<double, 2, 3> J;
  J << camera.fx * inverse_z, 0, -camera.fx * inverse_z * tan_x,  //
      0, camera.fy * inverse_z, -camera.fy * inverse_z * tan_y;
  const Eigen::Matrix<double, 2, 3> JW = J * camera.rotation();
  const Eigen::Matrix<double, 2, 3> T = (JW * F.cast<double>()) * rest.M.cast<double>();
  const Eigen::Vector3d t0 = T.row(0), t1 = T.row(1);
  const double raw_xx = t0.squaredNorm(), raw_yy = t1.squaredNorm();
  const double xx = raw_xx + kLowPass, yy = raw_yy + kLowPass, xy = t0.dot(t1);
  // det(T T^T + k I) by Cauchy-Binet: a sum of positive terms, where xx yy - xy^2 would cancel for needles.
  const double raw_det = t0.cross(t1).squaredNorm();
  const double det = raw_det + kLowPass * (raw_xx + raw_yy) + kLowPass * kLowPass;
  if (!std::isfinite(det)) return Projection::not_finite;

  const float opacity = g.antialiased ? static_cast<float>(rest.opacity * std::sqrt(raw_det / det)) : rest.opacity;
  if (!(opacity >= kMinAlpha)) return Projection::hidden;
  const double q_max = 2 * std::log(255.0 * opacity);
  const double reach = std::sqrt(std::max(q_max, 0.0));
  const Eigen::Vector2d center = camera.project(t);
  const double reach_x = reach * std::sqrt(xx), reach_y = reach * std::sqrt(yy);
  if (!(center.x() + reach_x > 0 && center.x() - reach_x < camera.width && center.y() + reach_y > 0 &&
        center.y() - reach_y < camera.height)) {
    return Projection::hidden;
  }

  // Floors only matter for splats that are far larger than any image, and keep the factors invertible.
  constexpr double kTiny = 1e-30;
  splat->x = center.x();
  splat->y = center.y();
  splat->a = static_cast<float>(std::max(std::sqrt(yy / det), kTiny));
  splat->b = static_cast<float>(-xy / std::sqrt(det) / std::sqrt(yy));
  splat->c = static_cast<float>(std::max(1 / std::sqrt(yy), kTiny));
  splat->log2_opacity = static_cast<float>(std::log2(opacity));
  // A pixel exactly at the threshold must not be lost to rounding here: the rasteriser tests every pixel's alpha.
  splat->reach = static_cast<float>(reach) + 1e-3f;
  splat->half_x = static_cast<float>(splat->reach * std::sqrt(xx));
  splat->half_y = static_cast<float>(splat->reach * std::sqrt(yy));
  splat->depth = static_cast<float>(t.z());

  Eigen::Vector3d direction = mean - camera.center();
  if (setup.sh_degree > 0) {
    if (F != RowMatrix3f::Identity()) direction = polar_rotation(F.cast<double>()).transpose() * direction;
    direction.normalize();
  }
  const Eigen::Vector3f color = sh_color(setup.sh_degree, g.sh_of(i), direction.cast<float>());
  for (int k = 0; k < 3; ++k) splat->color[k] = color[k];
  return Projection::drawn;
}

}  // namespace physmas::splat
