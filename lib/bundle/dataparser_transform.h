// nerfstudio's dataparser_transforms.json: from the coordinates of the capture to those that it trains and exports in.
#ifndef PHYSMAS_BUNDLE_DATAPARSER_TRANSFORM_H
#define PHYSMAS_BUNDLE_DATAPARSER_TRANSFORM_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "bundle/captured_views.h"
#include "records/json_fwd.h"

namespace physmas::bundle {

// x -> scale (rotation x + translation). The capture is where the cameras stood before nerfstudio's applied_transform
// (its dataparser multiplies that one in).
struct DataparserTransform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = {0, 0, 0};
  double scale = 1;  // > 0

  // Moves and turns the camera; what it sees of points that move along stays the same.
  void apply(Camera& camera) const;
};

// {"transform": 3 or 4 rows of 4, "scale": s}. Errors (exit code 3) name file and field: a matrix that is no rotation,
// a scale that is not positive.
DataparserTransform load_dataparser_transform(const std::string& path);
DataparserTransform dataparser_transform_from(const Json& json, const std::string& file);

// The file dataparser_transforms.json in the folder of the Gaussians, else in that of the cameras; empty when there is
// none.
std::string find_dataparser_transform(const std::string& gaussians, const std::string& cameras);

}  // namespace physmas::bundle

#endif
