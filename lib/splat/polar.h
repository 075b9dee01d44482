// The rotation in a deformation gradient.
#ifndef PHYSMAS_SPLAT_POLAR_H
#define PHYSMAS_SPLAT_POLAR_H

#include <Eigen/Core>

#include "mpm/math/svd.h"

namespace physmas::splat {

// The proper rotation (det +1) nearest to F: the polar rotation when det F > 0, and for inverted or singular F the one
// that flips the axis of the smallest singular value. Identity when F is zero or an entry of it not finite.
inline Eigen::Matrix3d polar_rotation(const Eigen::Matrix3d& F) {
  if (!F.allFinite() || F.isZero(0)) return Eigen::Matrix3d::Identity();
  mpm::Mat3d deformation;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) deformation[i][j] = F(i, j);
  }
  const mpm::Mat3d R = mpm::polar_rotation(deformation);
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rotation(i, j) = R[i][j];
  }
  return rotation;
}

}  // namespace physmas::splat

#endif
