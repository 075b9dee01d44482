// Where views show Gaussian means, and which views see them: the depth test of the run specification's
// `lifting.occlusion`.
#ifndef PHYSMAS_SPLAT_VISIBILITY_H
#define PHYSMAS_SPLAT_VISIBILITY_H

#include <cstdint>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"

namespace physmas::splat {

// Where Gaussian means fall in one view: the index of the pixel, or -1 outside Omega_i (depth not positive, or the
// projection outside the image). [N]
std::vector<int32_t> project_to_pixels(const std::vector<Eigen::Vector3f>& means, const Camera& camera);

// How much deeper than the rendered depth at its pixel a Gaussian's mean may lie and still be seen, scene units: 1/400
// of the scene's size, and `deviations` of the Gaussian's own standard deviations along the ray from the camera to its
// mean. position: the mean, scene space; F: its deformation gradient; default_near: Renderer::default_near().
double depth_slack(const Gaussians& gaussians, size_t i, const Eigen::Vector3f& position, const Eigen::Matrix3f& F,
                   const Camera& camera, double default_near, double deviations);

// [view][N] 1 where the Gaussian's mean lies no deeper than the rendered depth at its pixel and depth_slack with one
// standard deviation; 0 behind it and outside the image. A translucent Gaussian (opacity below 0.5) is not seen where
// the pixel has another chromaticity, both being lit: what the view shows there lies behind it, as a beverage does
// behind its glass.
std::vector<std::vector<uint8_t>> visible_in_views(const Gaussians& gaussians, const std::vector<Camera>& cameras);

}  // namespace physmas::splat

#endif
