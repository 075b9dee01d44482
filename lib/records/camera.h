// Calibrated pinhole cameras, as records hold them.
#ifndef PHYSMAS_RECORDS_CAMERA_H
#define PHYSMAS_RECORDS_CAMERA_H

#include <Eigen/Core>
#include <Eigen/LU>
#include <string>

#include "records/json_fwd.h"

namespace physmas {

// Pinhole camera with OpenCV axes (x right, y down, z forward). Image coordinates have their origin at the corner of
// the first pixel, so the centre of pixel i is at i + 0.5, and cx, cy are in that same axis.
struct Camera {
  int width = 0;                                                  // pixels
  int height = 0;                                                 // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;                          // pixels
  Eigen::Matrix4d world_to_camera = Eigen::Matrix4d::Identity();  // rigid, scene units

  Eigen::Matrix3d rotation() const { return world_to_camera.topLeftCorner<3, 3>(); }
  Eigen::Vector3d translation() const { return world_to_camera.topRightCorner<3, 1>(); }
  // The camera's position in the scene.
  Eigen::Vector3d center() const { return -rotation().transpose() * translation(); }
  // A scene point in camera space; z is its depth.
  Eigen::Vector3d to_camera(const Eigen::Vector3d& p) const { return rotation() * p + translation(); }
  // Pixel coordinates of a camera-space point with positive depth.
  Eigen::Vector2d project(const Eigen::Vector3d& q) const { return {fx * q.x() / q.z() + cx, fy * q.y() / q.z() + cy}; }
};

// `json` fits the schema; file, pointer: where it stands, for messages. Throws an Error (exit code 3) when the rotation
// is none.
Camera camera_from(const Json& json, const std::string& file, const std::string& pointer);
Json to_json(const Camera& camera);

}  // namespace physmas

#endif
