// Material fields as other programs write them.
#ifndef PHYSMAS_BUNDLE_MATERIAL_FILES_H
#define PHYSMAS_BUNDLE_MATERIAL_FILES_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "records/material_field.h"

namespace physmas::bundle {

// Samples as their file has them, [n] each.
struct MaterialSamples {
  std::vector<Eigen::Vector3d> position;  // in the coordinates of the file of Gaussians
  std::vector<double> E, nu, rho;         // Pa, 1, kg/m^3
};

// A field of 1 to kMaxFieldSamples samples from
//   .npz   arrays positions [n, 3], youngs_modulus, poisson_ratio and density, [n] or [n, 1] each
//   .usda  prims with points and yms, prs and rhos, with or without primvars: (usda_points.h)
// by their content. Errors (exit code 3): an array that is missing, other shapes, numbers that are not finite or of no
// material, other formats of USD, by name.
MaterialSamples load_material_samples(const std::string& path);
// The same from the file's bytes; `file` is only named in messages.
MaterialSamples parse_material_samples(const std::string& bytes, const std::string& file);

// In scene space: offset is what the import subtracted of the Gaussians, turn how it turned them then.
MaterialField placed_samples(const MaterialSamples& samples, const Eigen::Vector3d& offset,
                             const Eigen::Matrix3d& turn);

}  // namespace physmas::bundle

#endif
