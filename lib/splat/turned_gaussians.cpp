#include "splat/turned_gaussians.h"

#include <Eigen/Geometry>

#include "records/run_specification.h"
#include "splat/sh_rotation.h"

namespace physmas::splat {

void turn_gaussians(Gaussians& gaussians, const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond turn(R);
  const int count = sh_coefficient_count(gaussians.sh_degree);
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < gaussians.size(); ++i) {
    gaussians.position[i] = (R * gaussians.position[i].cast<double>()).cast<float>();
    std::array<float, 4>& q = gaussians.rotation[i];
    const Eigen::Quaterniond turned = turn * Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    q = {static_cast<float>(turned.w()), static_cast<float>(turned.x()), static_cast<float>(turned.y()),
         static_cast<float>(turned.z())};
    if (gaussians.sh_degree > 0) rotate_sh(gaussians.sh_degree, R, &gaussians.sh[i * count]);
  }
}

namespace {

// Columns: right, forward, up.
Eigen::Matrix3d axes_of(const std::string& name) {
  const Eigen::Vector3d up = axis_vector(name);
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();
  if (up.y() != 0) forward = -up.y() * Eigen::Vector3d::UnitZ();
  if (up.z() < 0) forward = -Eigen::Vector3d::UnitY();
  Eigen::Matrix3d axes;
  axes << forward.cross(up), forward, up;
  return axes;
}

}  // namespace

Eigen::Matrix3d turn_between(const std::string& from, const std::string& to) {
  return axes_of(to) * axes_of(from).transpose();
}

}  // namespace physmas::splat
