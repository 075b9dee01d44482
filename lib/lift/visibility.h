// Which views see a Gaussian: the depth test of the run specification's `lifting.occlusion`.
#ifndef PHYSMAS_LIFT_VISIBILITY_H
#define PHYSMAS_LIFT_VISIBILITY_H

#include <cstdint>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"

namespace physmas::lift {

// [view][N] 1 where the Gaussian's mean lies no deeper than the rendered depth at its pixel, give or take 1/400 of the
// scene's size and the Gaussian's own largest standard deviation; 0 behind it and outside the image.
std::vector<std::vector<uint8_t>> visible_in_views(const Gaussians& gaussians, const std::vector<Camera>& cameras);

}  // namespace physmas::lift

#endif
