// Turning a Gaussian's colour with the Gaussian.
#ifndef PHYSMAS_SPLAT_SH_ROTATION_H
#define PHYSMAS_SPLAT_SH_ROTATION_H

#include <Eigen/Core>

namespace physmas::splat {

// Replaces the (degree + 1)^2 colour triples `sh` by those whose colour in a direction d is the old one's in R^T d:
// what a static viewer must be given for a Gaussian that R has turned. R: a rotation; degree: 0..3, see splat/sh.h for
// the basis. Every degree turns within itself, so the constant term stays.
void rotate_sh(int degree, const Eigen::Matrix3d& R, Eigen::Vector3f* sh);

}  // namespace physmas::splat

#endif
