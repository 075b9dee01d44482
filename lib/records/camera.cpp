#include "records/camera.h"

#include <Eigen/LU>

#include "records/json.h"

namespace physmas {

Camera camera_from(const Json& json, const std::string& file, const std::string& pointer) {
  Camera camera;
  camera.width = json.at("width").get<int>();
  camera.height = json.at("height").get<int>();
  camera.fx = json.at("fx").get<double>();
  camera.fy = json.at("fy").get<double>();
  camera.cx = json.at("cx").get<double>();
  camera.cy = json.at("cy").get<double>();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) camera.world_to_camera(r, c) = json.at("world_to_camera")[r][c].get<double>();
  }
  const Eigen::Matrix3d R = camera.rotation();
  const bool rigid = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-4 &&
                     R.determinant() > 0 &&
                     (camera.world_to_camera.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-9;
  if (!rigid) {
    throw invalid_field(file, pointer + "/world_to_camera", json.at("world_to_camera"),
                        "a rigid transform: rotation with determinant +1, last row 0 0 0 1");
  }
  return camera;
}

Json to_json(const Camera& camera) {
  Json json;
  json["width"] = camera.width;
  json["height"] = camera.height;
  json["fx"] = camera.fx;
  json["fy"] = camera.fy;
  json["cx"] = camera.cx;
  json["cy"] = camera.cy;
  json["world_to_camera"] = Json::array();
  for (int r = 0; r < 4; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 4; ++c) row.push_back(camera.world_to_camera(r, c));
    json["world_to_camera"].push_back(row);
  }
  return json;
}

}  // namespace physmas
