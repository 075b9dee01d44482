// The boundary conditions of a PhysGaussian configuration (Xie et al. 2024; its mpm_solver_warp): colliders, and
// motions that are named.
#ifndef PHYSMAS_BUNDLE_PHYSGAUSSIAN_BOUNDARIES_H
#define PHYSMAS_BUNDLE_PHYSGAUSSIAN_BOUNDARIES_H

#include <Eigen/Core>
#include <vector>

#include "bundle/foreign_json.h"
#include "records/json.h"

namespace physmas::bundle {

// PhysGaussian's solver space against ours: turned about (1, 1, 1), where both put the middle of the scene.
struct PhysGaussianFrame {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();  // scene to PhysGaussian's axes, quarter turns
  double duration = 1;                                   // seconds of the run

  Eigen::Vector3d direction(const Eigen::Vector3d& v) const { return turned.transpose() * v; }
  Eigen::Vector3d point(const Eigen::Vector3d& p) const {
    return Eigen::Vector3d::Ones() + direction(p - Eigen::Vector3d::Ones());
  }
};

struct PhysGaussianBoundaries {
  Json colliders = Json::array();    // of the run specification
  std::vector<Omission> not_mapped;  // a JSON pointer and why
};

// Of config's `boundary_conditions`. `bounding_box` is our walls; a `cuboid` at rest for the whole run, whose grid
// nodes have velocity 0, a sticky box; a `surface_collider` for the whole run a plane. The rest moves or holds
// particles that are in a box at the start. Our actions do that for parts, which no one knows here; so each is named
// with what it does in scene axes, and with the action that does the like. Errors (exit code 3) name file and field.
PhysGaussianBoundaries physgaussian_boundaries(const ForeignObject& config, const PhysGaussianFrame& frame);

}  // namespace physmas::bundle

#endif
