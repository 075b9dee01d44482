#include "bundle/turned_gaussians.h"

#include <Eigen/Geometry>

#include "splat/sh_rotation.h"

namespace physmas::bundle {

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
    if (gaussians.sh_degree > 0) splat::rotate_sh(gaussians.sh_degree, R, &gaussians.sh[i * count]);
  }
}

}  // namespace physmas::bundle
