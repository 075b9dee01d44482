// A static scene turned as a whole.
#ifndef PHYSMAS_SPLAT_TURNED_GAUSSIANS_H
#define PHYSMAS_SPLAT_TURNED_GAUSSIANS_H

#include <string>

#include "scene/gaussians.h"

namespace physmas::splat {

// Turns every Gaussian about the origin by the rotation R: means, orientations and the directions of its colours.
// Scales and opacities keep their stored values, quaternions their norm.
void turn_gaussians(Gaussians& gaussians, const Eigen::Matrix3d& R);

// The rotation after which the scene axis `from` points along `to`, and the usual front (docs/scenes.md) of the one is
// that of the other. from, to: "x" to "-z".
Eigen::Matrix3d turn_between(const std::string& from, const std::string& to);

}  // namespace physmas::splat

#endif
