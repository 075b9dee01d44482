#include "splat/fitted_camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/constants.h"
#include "base/error.h"
#include "splat/middle_box.h"

namespace physmas::splat {
namespace {

using Eigen::Vector3d;

constexpr double kDeviations = 2;  // of a Gaussian, that shall be in the picture
constexpr double kWidest = 0.1;    // of the scene's size

// Tangents of the picture's edges, less the free margin.
struct Edges {
  double right, left, down, up;
};

Edges edges_of(const Camera& c) {
  const double free_x = 0.5 * kFreeEdge * c.width, free_y = 0.5 * kFreeEdge * c.height;
  return {(c.width - c.cx - free_x) / c.fx, (c.cx - free_x) / c.fx, (c.height - c.cy - free_y) / c.fy,
          (c.cy - free_y) / c.fy};
}

// The Gaussians that count, by object. When all are faint, all count.
std::vector<std::vector<size_t>> counted_by_object(const Gaussians& gaussians, const State& state) {
  std::vector<std::vector<size_t>> objects;
  const bool all_faint = [&] {
    for (size_t i = 0; i < gaussians.size(); ++i) {
      if (gaussians.opacity(i) >= kFaintOpacity) return false;
    }
    return true;
  }();
  for (size_t i = 0; i < gaussians.size(); ++i) {
    if (!all_faint && gaussians.opacity(i) < kFaintOpacity) continue;
    const size_t object = static_cast<size_t>(state.gaussian_object[i]);
    if (object >= objects.size()) objects.resize(object + 1);
    objects[object].push_back(i);
  }
  return objects;
}

// How far these Gaussians reach beyond each edge, the outermost kMayLeave left out. A Gaussian reaches kDeviations of
// its standard deviations across the plane of the edge; single huge ones, which captures have, as far as `widest`.
PictureReach reach_of(const TransportedFrame& frame, const std::vector<RestShape>& rest, double widest,
                      const std::vector<size_t>& points, const Camera& camera) {
  const Edges edges = edges_of(camera);
  const std::array<Vector3d, 4> normals = {Vector3d(1, 0, -edges.right), Vector3d(-1, 0, -edges.left),
                                           Vector3d(0, 1, -edges.down), Vector3d(0, -1, -edges.up)};
  std::array<double, 4> reach;
#pragma omp parallel for
  for (int k = 0; k < 4; ++k) {
    const Vector3d normal = camera.rotation().transpose() * normals[k];
    const double offset = normals[k].dot(camera.translation());
    std::vector<double> beyond;
    beyond.reserve(points.size());
    for (const size_t i : points) {
      const double at = normal.dot(frame.position(i).cast<double>()) + offset;
      const double width = (rest[i].M.transpose() * (frame.F(i).transpose() * normal.cast<float>())).norm();
      if (std::isfinite(at) && std::isfinite(width)) beyond.push_back(at + std::min(kDeviations * width, widest));
    }
    reach[k] = PictureReach::kNothing;
    if (beyond.empty()) continue;
    const size_t out = static_cast<size_t>(kMayLeave * static_cast<double>(beyond.size()));
    const auto nth = beyond.end() - 1 - static_cast<std::ptrdiff_t>(out);
    std::nth_element(beyond.begin(), nth, beyond.end());
    reach[k] = *nth;
  }
  return {reach[0], reach[1], reach[2], reach[3]};
}

constexpr std::array<double PictureReach::*, 4> kSides = {&PictureReach::right, &PictureReach::left,
                                                          &PictureReach::down, &PictureReach::up};

// One axis of the picture: the camera's offset along it, `low`..`high` where all is inside.
struct Range {
  double low, high;
};
Range range_at(double distance, double plus, double minus, double plus_edge, double minus_edge) {
  return {plus - plus_edge * distance, minus_edge * distance - minus};
}

double offset_at(double distance, double plus, double minus, double rest_plus, double rest_minus, double plus_edge,
                 double minus_edge) {
  const Range all = range_at(distance, plus, minus, plus_edge, minus_edge);
  // Rounding must not lose the smallest distance.
  if (all.low <= all.high + 1e-12 * (1 + std::abs(all.low)))
    return std::clamp(0.0, std::min(all.low, all.high), all.high);
  const Range rest = range_at(distance, rest_plus, rest_minus, plus_edge, minus_edge);
  return std::clamp(0.5 * (all.low + all.high), std::min(rest.low, rest.high), rest.high);
}

}  // namespace

std::vector<Camera> base_cameras(const Scene& scene, const Gaussians& gaussians) {
  if (scene.run.render.camera_mode() != RunSpecification::Render::CameraMode::orbit) return scene.output_cameras;
  if (scene.output_cameras.size() != 1) {
    throw invalid_input({scene.file, "/output_cameras", fmt::format("{} cameras", scene.output_cameras.size()),
                         "one, since render.camera is orbit", "render.camera=fit follows the scene's own path"});
  }
  const Camera& first = scene.output_cameras[0];
  const Vector3d middle = middle_box(gaussians).center(), up = scene.run.placement.up_vector();
  std::vector<Camera> cameras;
  for (int t = 0; t < scene.run.time.frames; ++t) {
    const double angle = std::min(kOrbitSpeed * t * scene.run.time.frame_dt, 360.0) * kPi / 180;
    // Turning the camera is turning the scene the other way.
    const Eigen::Matrix3d back = Eigen::AngleAxisd(-angle, up).toRotationMatrix();
    Camera camera = first;
    camera.world_to_camera.topLeftCorner<3, 3>() = first.rotation() * back;
    camera.world_to_camera.topRightCorner<3, 1>() = first.rotation() * (middle - back * middle) + first.translation();
    cameras.push_back(camera);
  }
  return cameras;
}

void add_motion(const Gaussians& gaussians, const State& state, int frames,
                const std::function<TransportedFrame(int)>& frame_at, const std::vector<Camera>& base,
                FittedCameras& fitted) {
  const std::vector<std::vector<size_t>> objects = counted_by_object(gaussians, state);
  const double widest = kWidest * middle_box(gaussians).diagonal().norm();
  std::vector<RestShape> rest(gaussians.size());
  for (size_t i = 0; i < rest.size(); ++i) rest[i] = rest_shape(gaussians, i);
  std::vector<PictureReach> at_rest(objects.size());
  for (int t = 0; t < frames; ++t) {
    const TransportedFrame frame = frame_at(t);
    for (size_t object = 0; object < objects.size(); ++object) {
      const PictureReach reach = reach_of(frame, rest, widest, objects[object], base.size() == 1 ? base[0] : base[t]);
      if (t == 0) at_rest[object] = reach;
      for (const auto side : kSides) {
        const double beyond = reach.*side - std::max(0.0, at_rest[object].*side);
        fitted.reach.*side = std::max(fitted.reach.*side, beyond);
        if (t == 0) fitted.rest.*side = std::max(fitted.rest.*side, beyond);
      }
    }
  }
}

void place_cameras(const Gaussians& gaussians, const std::vector<Camera>& base, FittedCameras& fitted) {
  const PictureReach &reach = fitted.reach, &rest = fitted.rest;
  fitted.cameras = base;
  fitted.distance = 1;
  fitted.omitted.clear();
  const bool inside = reach.right <= 0 && reach.left <= 0 && reach.down <= 0 && reach.up <= 0;
  if (inside) return;
  Edges edges = edges_of(base[0]);
  for (const Camera& camera : base) {
    const Edges other = edges_of(camera);
    edges = {std::min(edges.right, other.right), std::min(edges.left, other.left), std::min(edges.down, other.down),
             std::min(edges.up, other.up)};
  }
  const double needed = std::max({0.0, (reach.right + reach.left) / (edges.right + edges.left),
                                  (reach.down + reach.up) / (edges.down + edges.up)});
  const Vector3d middle = middle_box(gaussians).center();
  const double stands = std::max(base[0].to_camera(middle).z(), 1e-9 * (base[0].center() - middle).norm());
  const double back = std::min(needed, (kFarthest - 1) * stands);
  const double x = offset_at(back, reach.right, reach.left, rest.right, rest.left, edges.right, edges.left);
  const double y = offset_at(back, reach.down, reach.up, rest.down, rest.up, edges.down, edges.up);
  for (Camera& camera : fitted.cameras) camera.world_to_camera.topRightCorner<3, 1>() -= Vector3d(x, y, -back);
  fitted.distance = 1 + back / stands;
  if (back < needed) {
    fitted.omitted.push_back({"motion outside the picture",
                              fmt::format("to see all of it the camera would stand {:.3g} times as far from the scene; "
                                          "{} is the most",
                                          1 + needed / stands, kFarthest)});
  }
}

}  // namespace physmas::splat
