// Distortion of camera lenses, and pictures without it.
#ifndef PHYSMAS_BUNDLE_DISTORTION_H
#define PHYSMAS_BUNDLE_DISTORTION_H

#include <string>

#include "scene/camera.h"
#include "scene/image.h"

namespace physmas::bundle {

// Radial and tangential distortion (Brown 1966; COLMAP's SIMPLE_RADIAL to OPENCV, OpenCV's k1 k2 p1 p2 k3).
struct Distortion {
  double k1 = 0, k2 = 0, k3 = 0;  // of r^2, r^4, r^6
  double p1 = 0, p2 = 0;

  bool none() const { return k1 == 0 && k2 == 0 && k3 == 0 && p1 == 0 && p2 == 0; }
  // Where the lens puts what a pinhole puts at `p`, both at distance 1 from the camera.
  Eigen::Vector2d distorted(const Eigen::Vector2d& p) const;
};

// Throws an Error (exit code 3) that names file and field when the distortion folds the camera's image over somewhere,
// so that no picture without distortion exists.
void require_unfolded(const Distortion& distortion, const Camera& camera, const std::string& file,
                      const std::string& field);

// The picture that a pinhole with the same intrinsics takes. image: as large as the camera says. Bilinear; where the
// lens saw nothing, the nearest pixel of its border.
Image undistorted(const Image& image, const Camera& camera, const Distortion& distortion);

}  // namespace physmas::bundle

#endif
