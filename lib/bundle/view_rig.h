// Where cameras stand: the four views of a bundle and its output camera.
#ifndef PHYSMAS_BUNDLE_VIEW_RIG_H
#define PHYSMAS_BUNDLE_VIEW_RIG_H

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"

namespace physmas::bundle {

// The views that the project makes itself, in the order of scene.json.
inline constexpr std::array<const char*, 4> kViewNames = {"front", "right", "back", "left"};

// Columns: right, the way the front camera looks, up; a rotation. For up = z it is the identity, so the front camera
// looks along +y; for y it looks along -z, for -y along +z (both as captures with that up axis usually stand).
// front: degrees about up by which that is turned, from the front towards the right. Throws an Error (exit code 2) when
// `up` is no axis.
Eigen::Matrix3d scene_axes(const std::string& up, double front = 0);

// The degrees that `front` stands for: an axis, "x" or "-y", is where the front of things faces and the front camera
// stands; a number from -360 to 360 is itself; anything else is nothing. Throws an Error (exit code 2) for an axis
// along up.
std::optional<double> front_degrees(const std::string& front, const std::string& up);

// Where a camera stands, seen from `center`: degrees about up from the usual front towards the right; 0 on the axis.
double azimuth_of(const Camera& camera, const Eigen::Vector3d& center, const std::string& up);

// The middle of the box around the points (at least one).
Eigen::Vector3d middle_of(const std::vector<Eigen::Vector3d>& points);

struct ViewDirection {
  double azimuth = 0;    // degrees, from the front towards the right, about up
  double elevation = 0;  // degrees above the horizon, -80..80
};

struct Framing {
  std::string up = "z";
  double fov = 40;       // full vertical angle of view, degrees
  double margin = 0.08;  // part of the half width and half height that stays free
  int width = 0, height = 0;
  double front = 0;  // degrees that scene_axes takes
};

// The nearest camera with that direction that sees all points (scene units, at least one), centred on them.
Camera frame_points(const std::vector<Eigen::Vector3d>& points, const ViewDirection& direction, const Framing& framing);

// Front, right, back and left at one elevation and one distance, the smallest at which each sees all points.
std::vector<Camera> view_cameras(const std::vector<Eigen::Vector3d>& points, double elevation, const Framing& framing);

// The means of all Gaussians.
std::vector<Eigen::Vector3d> means_of(const Gaussians& gaussians);

// The box between the 0.5 % and 99.5 % quantiles of the means per axis, weighted by opacity and widened by a tenth on
// every side. gaussians: at least one.
Eigen::AlignedBox3d robust_box_of(const Gaussians& gaussians);

// The means without stray Gaussians: those inside the robust box. Never empty when there are Gaussians.
std::vector<Eigen::Vector3d> robust_means_of(const Gaussians& gaussians);

}  // namespace physmas::bundle

#endif
