// PhysGaussian's configuration files (Xie et al. 2024; its utils/decode_param.py) as a run specification.
#ifndef PHYSMAS_BUNDLE_PHYSGAUSSIAN_H
#define PHYSMAS_BUNDLE_PHYSGAUSSIAN_H

#include <string>
#include <vector>

#include "bundle/selection.h"
#include "records/json.h"

namespace physmas::bundle {

struct PhysGaussianImport {
  Json run;             // run specification, up included; colliders always, so that no floor is added
  Selection selection;  // opacity_threshold and sim_area, scene units
  // The solver's axes are the scene's. Quarter turns between the scene and PhysGaussian's solver are undone in `run`,
  // so that the scene stays as it is; by any other rotation it has to be turned first, with its cameras. Everything
  // else in here is of the turned scene.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  std::string up;  // axis of the turned scene
  // Material hints, for a record of material observations: the visual label whose branch is the configuration's
  // material, nearest in E and then in density.
  int label = 0;
  double E = 0, nu = 0;
  // What has no counterpart here, or another meaning: a JSON pointer into the configuration, and why.
  std::vector<Omission> not_mapped;
};

// Reads a configuration; what it leaves out has PhysGaussian's default. Its solver space is the scene turned about the
// origin by every rotation_degree about its rotation_axis, one after the other. Errors (exit code 3) name file and
// field.
PhysGaussianImport load_physgaussian(const std::string& path);
// The same for JSON that is already parsed; `file` is only named in messages.
PhysGaussianImport physgaussian_from(const Json& json, const std::string& file);

// The hints as a record of material observations (schemas/material_records.json): for every key and for the
// whole object.
Json material_hints(const PhysGaussianImport& import, const std::vector<std::string>& keys);

}  // namespace physmas::bundle

#endif
