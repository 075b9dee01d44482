// Where a camera stands.
#ifndef PHYSMAS_SCENE_CAMERA_H
#define PHYSMAS_SCENE_CAMERA_H

#include "records/camera.h"

namespace physmas {

// A camera at `eye` that looks at `target` with `up` towards the top of the image (all scene space).
// fov_y: full vertical angle of view [radians], 0 < fov_y < pi. `up` must not be parallel to the view direction.
Camera look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up, double fov_y,
               int width, int height);

}  // namespace physmas

#endif
