// The object of a scene: where its Gaussians lie close together.
#ifndef PHYSMAS_BUNDLE_DENSE_COMPONENT_H
#define PHYSMAS_BUNDLE_DENSE_COMPONENT_H

#include <Eigen/Geometry>
#include <string>

#include "scene/gaussians.h"

namespace physmas::bundle {

// Gaussians that lie as close together as the densest quarter of the scene does, in cubes that touch.
struct DenseComponent {
  Eigen::AlignedBox3d box;  // around the cubes of the component with the largest sum of opacities, scene units
  size_t count = 0;         // its Gaussians
  double share = 0;         // of the opacities of all, 0..1
};

// Deterministic. gaussians: at least one.
DenseComponent dense_component(const Gaussians& gaussians);

// A warning when most Gaussians lie in a component so small that what is around it, a sky or a distant background,
// would make it a few cells large in the solver; else empty. offset: of the file's coordinates (GaussianNotes).
std::string surroundings_warning(const Gaussians& gaussians, const DenseComponent& component,
                                 const Eigen::Vector3d& offset);

// "x0 x1 y0 y1 z0 z1", for --crop.
std::string crop_text(const Eigen::AlignedBox3d& box);

}  // namespace physmas::bundle

#endif
