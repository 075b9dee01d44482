// A static scene turned as a whole.
#ifndef PHYSMAS_BUNDLE_TURNED_GAUSSIANS_H
#define PHYSMAS_BUNDLE_TURNED_GAUSSIANS_H

#include "scene/gaussians.h"

namespace physmas::bundle {

// Turns every Gaussian about the origin by the rotation R: means, orientations and the directions of its colours.
// Scales and opacities keep their stored values, quaternions their norm.
void turn_gaussians(Gaussians& gaussians, const Eigen::Matrix3d& R);

}  // namespace physmas::bundle

#endif
