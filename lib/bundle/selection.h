// Which Gaussians of a file are taken, and which stray ones are worth a warning.
#ifndef PHYSMAS_BUNDLE_SELECTION_H
#define PHYSMAS_BUNDLE_SELECTION_H

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "scene/gaussians.h"

namespace physmas::bundle {

struct Selection {
  double opacity_threshold = 0;                             // Gaussians of a higher opacity stay; 0 keeps all
  std::optional<Eigen::AlignedBox3d> crop;                  // means strictly inside stay, scene units
  bool crop_dense = false;                                  // instead of `crop`: the box of dense_component
  Eigen::Matrix3d crop_axes = Eigen::Matrix3d::Identity();  // turns means into the crop's axes
};

// A crop box from "x0 x1 y0 y1 z0 z1" (the order of PhysGaussian's sim_area). Throws an Error (exit code 2) that names
// `option` unless the upper end of every axis is above the lower one.
Eigen::AlignedBox3d crop_box(const std::vector<double>& bounds, const std::string& option);

// Removes the others and returns how many they were; values of those that stay are kept bit for bit. Throws an Error
// (exit code 3, naming `file`) when none stays. Both comparisons are PhysGaussian's.
size_t select_gaussians(Gaussians& gaussians, const Selection& selection, const std::string& file);

// Floaters: the means outside the robust box (view_rig.h). They matter because the placement scales the box around all
// means to the solver's extent; `ratio` is the longest side of that box over the robust box's.
struct Floaters {
  size_t count = 0;
  double ratio = 1;
  Eigen::AlignedBox3d box;  // robust, scene units
};
Floaters find_floaters(const Gaussians& gaussians);

// A warning when floaters make the scene smaller in the solver by more than a quarter (ratio above 1.25), with the
// --crop that removes them; else empty. offset: of the file's coordinates (GaussianNotes).
std::string floater_warning(const Floaters& floaters, const Eigen::Vector3d& offset = {0, 0, 0});

}  // namespace physmas::bundle

#endif
