#include "bundle/dataparser_transform.h"

#include <filesystem>

#include "base/file.h"
#include "bundle/foreign_json.h"
#include "records/json.h"

namespace fs = std::filesystem;

namespace physmas::bundle {

DataparserTransform dataparser_transform_from(const Json& json, const std::string& file) {
  const ForeignObject object(json, file, "");
  const Eigen::MatrixXd matrix = object.matrix("transform", 3, 4);
  DataparserTransform transform;
  const Camera pose = camera_at_pose(matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>(), file, "/transform");
  transform.rotation = pose.rotation().transpose();
  transform.translation = matrix.topRightCorner<3, 1>();
  transform.scale = object.positive("scale");
  return transform;
}

DataparserTransform load_dataparser_transform(const std::string& path) {
  return dataparser_transform_from(parse_json(read_file(path), path), path);
}

void DataparserTransform::apply(Camera& camera) const {
  const Eigen::Vector3d center = scale * (rotation * camera.center() + translation);
  const Eigen::Matrix3d R = camera.rotation() * rotation.transpose();
  camera.world_to_camera.topLeftCorner<3, 3>() = R;
  camera.world_to_camera.topRightCorner<3, 1>() = -R * center;
}

std::string find_dataparser_transform(const std::string& gaussians, const std::string& cameras) {
  std::error_code failure;
  const std::string beside_cameras = fs::is_directory(cameras, failure) ? cameras : folder_of(cameras);
  for (const std::string& folder : {folder_of(gaussians), beside_cameras}) {
    const std::string file = join_path(folder, "dataparser_transforms.json");
    if (fs::is_regular_file(file, failure)) return file;
  }
  return "";
}

}  // namespace physmas::bundle
