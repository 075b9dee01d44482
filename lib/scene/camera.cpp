#include "scene/camera.h"

#include <Eigen/Geometry>
#include <cmath>

namespace physmas {

Camera look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up, double fov_y,
               int width, int height) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  const Eigen::Vector3d down = forward.cross(right);
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.5 * height / std::tan(0.5 * fov_y);
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  camera.world_to_camera.setIdentity();
  camera.world_to_camera.block<1, 3>(0, 0) = right.transpose();
  camera.world_to_camera.block<1, 3>(1, 0) = down.transpose();
  camera.world_to_camera.block<1, 3>(2, 0) = forward.transpose();
  camera.world_to_camera.topRightCorner<3, 1>() = -camera.rotation() * eye;
  return camera;
}

}  // namespace physmas
