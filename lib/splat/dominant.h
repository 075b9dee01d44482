// Which Gaussian a pixel shows.
#ifndef PHYSMAS_SPLAT_DOMINANT_H
#define PHYSMAS_SPLAT_DOMINANT_H

#include <Eigen/Core>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "splat/renderer.h"

namespace physmas::splat {

// The Gaussian with the largest blending weight at the centre of each pixel (column, row), ties to the nearer one, -1
// where none is drawn; blended as Renderer does, which cannot tell as many labels as there are Gaussians. For some
// hundreds of pixels: every Gaussian is tried at each. near: depth from which Gaussians are drawn, scene units.
std::vector<int> dominant_gaussians(const Gaussians& gaussians, const Deformation& deformation, const Camera& camera,
                                    double near, const std::vector<Eigen::Vector2i>& pixels);

}  // namespace physmas::splat

#endif
