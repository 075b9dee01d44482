// Where most of a scene is.
#ifndef PHYSMAS_SPLAT_MIDDLE_BOX_H
#define PHYSMAS_SPLAT_MIDDLE_BOX_H

#include <Eigen/Geometry>

#include "scene/gaussians.h"

namespace physmas::splat {

// The box that holds the middle 90 % of the means per axis, scene units: stray Gaussians do not count. Around the
// origin, and of no size, when there are none.
Eigen::AlignedBox3d middle_box(const Gaussians& gaussians);

}  // namespace physmas::splat

#endif
