#include "bundle/view_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "base/constants.h"
#include "base/error.h"
#include "records/run_specification.h"

namespace physmas::bundle {
namespace {

using Eigen::Vector3d;

constexpr double kRadians = kPi / 180;
constexpr double kQuantile = 0.005, kWiden = 0.1;

// Where a camera that looks along `forward` must stand.
struct Stand {
  Vector3d right, down, forward;
  Vector3d target = Vector3d::Zero();  // a point on the optical axis
  double distance = 0;                 // smallest from the target
};

// With the target's offset c along an axis and the distance D, a point at (x, z) is in view when |x - c| <= t (z + D).
// Both sides hold with equality at the best c and the smallest D.
std::pair<double, double> fit_axis(const std::vector<Vector3d>& points, const Vector3d& center, const Vector3d& axis,
                                   const Vector3d& forward, double tangent) {
  double plus = -std::numeric_limits<double>::max(), minus = plus;
  for (const Vector3d& p : points) {
    const double x = axis.dot(p - center) / tangent, z = forward.dot(p - center);
    plus = std::max(plus, x - z);
    minus = std::max(minus, -x - z);
  }
  return {0.5 * tangent * (plus - minus), 0.5 * (plus + minus)};
}

Stand stand_for(const std::vector<Vector3d>& points, const ViewDirection& direction, const Framing& framing) {
  const Eigen::Matrix3d axes = scene_axes(framing.up, framing.front);
  const double a = direction.azimuth * kRadians, e = direction.elevation * kRadians;
  Stand stand;
  stand.forward = -(axes * Vector3d(std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e)));
  stand.right = stand.forward.cross(Vector3d(axes.col(2))).normalized();
  stand.down = stand.forward.cross(stand.right);
  Vector3d low = points.front(), high = points.front();
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector3d center = 0.5 * (low + high);
  const double tangent = std::tan(0.5 * framing.fov * kRadians) * (1 - framing.margin);
  const auto [x, x_distance] =
      fit_axis(points, center, stand.right, stand.forward, tangent * framing.width / framing.height);
  const auto [y, y_distance] = fit_axis(points, center, stand.down, stand.forward, tangent);
  stand.target = center + x * stand.right + y * stand.down;
  // A single point needs some distance as well.
  stand.distance = std::max({x_distance, y_distance, 1e-3 * (high - low).norm(), 1e-6});
  return stand;
}

Camera camera_at(const Stand& stand, double distance, const Framing& framing) {
  return look_at(stand.target - distance * stand.forward, stand.target, scene_axes(framing.up).col(2),
                 framing.fov * kRadians, framing.width, framing.height);
}

// The value below which a part `quantile` of the weight lies. values: sorted by the first member.
double weighted_quantile(const std::vector<std::pair<float, float>>& values, double total, double quantile) {
  double sum = 0;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= quantile * total) return value;
  }
  return values.back().first;
}

}  // namespace

Eigen::Matrix3d scene_axes(const std::string& up_name, double front) {
  const Vector3d up = axis_vector(up_name);
  Vector3d forward = Vector3d::UnitY();
  if (up.y() != 0) forward = -up.y() * Vector3d::UnitZ();
  if (up.z() < 0) forward = -Vector3d::UnitY();
  Eigen::Matrix3d axes;
  axes << forward.cross(up), forward, up;
  if (front == 0) return axes;
  // Quarter turns are exact, so that a front along an axis gives cameras along it.
  const double c = std::cos(front * kRadians), s = std::sin(front * kRadians);
  const auto exact = [](double v) { return std::abs(v - std::round(v)) < 1e-12 ? std::round(v) : v; };
  Eigen::Matrix3d turned = axes;
  turned.col(0) = exact(c) * axes.col(0) + exact(s) * axes.col(1);
  turned.col(1) = exact(c) * axes.col(1) - exact(s) * axes.col(0);
  return turned;
}

std::optional<double> front_degrees(const std::string& front, const std::string& up) {
  const std::string letter = front.substr(!front.empty() && front[0] == '-' ? 1 : 0);
  if (letter == "x" || letter == "y" || letter == "z") {
    const Vector3d faces = axis_vector(front);
    const Eigen::Matrix3d axes = scene_axes(up);
    if (faces.dot(axes.col(2)) != 0) {
      throw Error(ExitCode::usage,
                  fmt::format("--front: found {}, expected an axis across up, which is {}", front, up));
    }
    return std::atan2(faces.dot(axes.col(0)), -faces.dot(axes.col(1))) / kRadians;
  }
  double degrees = 0;
  const char* const end = front.data() + front.size();
  const auto [rest, failure] = std::from_chars(front.data(), end, degrees);
  if (failure != std::errc() || rest != end || !(std::abs(degrees) <= 360)) return std::nullopt;
  return degrees;
}

double azimuth_of(const Camera& camera, const Vector3d& center, const std::string& up) {
  const Eigen::Matrix3d axes = scene_axes(up);
  const Vector3d offset = camera.center() - center;
  return std::atan2(offset.dot(axes.col(0)), -offset.dot(axes.col(1))) / kRadians;
}

Vector3d middle_of(const std::vector<Vector3d>& points) {
  Vector3d low = points.front(), high = low;
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return 0.5 * (low + high);
}

Camera frame_points(const std::vector<Vector3d>& points, const ViewDirection& direction, const Framing& framing) {
  const Stand stand = stand_for(points, direction, framing);
  return camera_at(stand, stand.distance, framing);
}

std::vector<Camera> view_cameras(const std::vector<Vector3d>& points, double elevation, const Framing& framing) {
  std::vector<Stand> stands;
  double distance = 0;
  for (size_t i = 0; i < kViewNames.size(); ++i) {
    stands.push_back(stand_for(points, {90.0 * static_cast<double>(i), elevation}, framing));
    distance = std::max(distance, stands.back().distance);
  }
  std::vector<Camera> cameras;
  for (const Stand& stand : stands) cameras.push_back(camera_at(stand, distance, framing));
  return cameras;
}

std::vector<Vector3d> means_of(const Gaussians& gaussians) {
  std::vector<Vector3d> points;
  points.reserve(gaussians.size());
  for (const Eigen::Vector3f& p : gaussians.position) points.push_back(p.cast<double>());
  return points;
}

Eigen::AlignedBox3d robust_box_of(const Gaussians& gaussians) {
  Vector3d low, high;
#pragma omp parallel for schedule(static, 1)
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::pair<float, float>> values(gaussians.size());
    double total = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      values[i] = {gaussians.position[i][axis], gaussians.opacity(i)};
      total += values[i].second;
    }
    std::sort(values.begin(), values.end());
    low[axis] = weighted_quantile(values, total, kQuantile);
    high[axis] = weighted_quantile(values, total, 1 - kQuantile);
  }
  const Vector3d widen = kWiden * (high - low);
  return {low - widen, high + widen};
}

std::vector<Vector3d> robust_means_of(const Gaussians& gaussians) {
  std::vector<Vector3d> points = means_of(gaussians);
  if (points.empty()) return points;
  const Eigen::AlignedBox3d box = robust_box_of(gaussians);
  std::vector<Vector3d> kept;
  for (const Vector3d& p : points) {
    if (box.contains(p)) kept.push_back(p);
  }
  return kept.empty() ? points : kept;
}

}  // namespace physmas::bundle
