// Colour spaces.
#ifndef PHYSMAS_SCENE_COLOR_H
#define PHYSMAS_SCENE_COLOR_H

#include <Eigen/Core>

namespace physmas {

// CIELAB (D65) of an sRGB colour in 0..1. Euclidean distances in it are about how different two colours look.
Eigen::Vector3d lab_of_srgb(const Eigen::Vector3d& srgb);

}  // namespace physmas

#endif
