// Colour spaces.
#ifndef PHYSMAS_SCENE_COLOR_H
#define PHYSMAS_SCENE_COLOR_H

#include <Eigen/Core>

namespace physmas {

// CIELAB (D65) of an sRGB colour in 0..1. Euclidean distances in it are about how different two colours look.
Eigen::Vector3d lab_of_srgb(const Eigen::Vector3d& srgb);

// Shares of the channels of an sRGB colour, each first cut to 0.02..1; they add up to 1. Shading scales all channels
// alike and leaves them.
Eigen::Vector3f chromaticity(const Eigen::Vector3f& srgb);

}  // namespace physmas

#endif
