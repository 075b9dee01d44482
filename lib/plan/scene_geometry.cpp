#include "plan/scene_geometry.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace physmas::plan {
namespace {

struct Outline {
  Eigen::Vector2d centroid, low, high;  // pixels
};

std::optional<Outline> outline_of(const Mask& mask) {
  Outline o{Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(1e9), Eigen::Vector2d::Constant(-1e9)};
  long count = 0;
  for (int y = 0; y < mask.height && !mask.empty(); ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (mask.pixels[static_cast<size_t>(y) * mask.width + x] == 0) continue;
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      o.centroid += p;
      o.low = o.low.cwiseMin(p);
      o.high = o.high.cwiseMax(p);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  o.centroid /= static_cast<double>(count);
  return o;
}

// The box of one thing from its masks in all views ([view], null where not shown).
std::optional<Box> box_of(const std::vector<SceneView>& views, const std::vector<const Mask*>& masks) {
  std::vector<std::pair<const Camera*, Outline>> seen;
  for (size_t v = 0; v < views.size(); ++v) {
    if (const std::optional<Outline> outline = outline_of(*masks[v])) seen.emplace_back(&views[v].camera, *outline);
  }
  if (seen.size() < 2) return std::nullopt;
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& [camera, outline] : seen) {
    const Eigen::Vector3d in_camera((outline.centroid.x() - camera->cx) / camera->fx,
                                    (outline.centroid.y() - camera->cy) / camera->fy, 1);
    const Eigen::Vector3d ray = (camera->rotation().transpose() * in_camera).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    A += across;
    b += across * camera->center();
  }
  // Parallel rays (the same direction from every view) meet nowhere in particular.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(A);
  if (spectrum.eigenvalues()[0] < 1e-4) return std::nullopt;
  Box box;
  box.center = A.ldlt().solve(b);
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  for (const auto& [camera, outline] : seen) {
    const double depth = camera->to_camera(box.center).z();
    if (!(depth > 0)) return std::nullopt;
    for (int corner = 0; corner < 4; ++corner) {
      const double x = corner % 2 == 0 ? outline.low.x() : outline.high.x();
      const double y = corner / 2 == 0 ? outline.low.y() : outline.high.y();
      const Eigen::Vector3d in_camera(depth * (x - camera->cx) / camera->fx, depth * (y - camera->cy) / camera->fy,
                                      depth);
      const Eigen::Vector3d offset = camera->rotation().transpose() * (in_camera - camera->translation()) - box.center;
      // A view measures only the axes that it sees from the side.
      for (int a = 0; a < 3; ++a) {
        if (std::abs(camera->rotation()(2, a)) > 0.5) continue;
        low[a] = std::min(low[a], offset[a]);
        high[a] = std::max(high[a], offset[a]);
      }
    }
  }
  box.half = 0.5 * (high - low);
  box.center += 0.5 * (high + low);
  return box;
}

}  // namespace

Eigen::Vector3d SceneGeometry::axis(DirectionWord word) const {
  switch (word) {
    case DirectionWord::up:
      return up;
    case DirectionWord::down:
      return -up;
    case DirectionWord::left:
      return -right;
    case DirectionWord::right:
      return right;
    case DirectionWord::toward:
      return toward;
    case DirectionWord::away:
      return -toward;
    case DirectionWord::plus_x:
      return Eigen::Vector3d::UnitX();
    case DirectionWord::minus_x:
      return -Eigen::Vector3d::UnitX();
    case DirectionWord::plus_y:
      return Eigen::Vector3d::UnitY();
    case DirectionWord::minus_y:
      return -Eigen::Vector3d::UnitY();
    case DirectionWord::plus_z:
      return Eigen::Vector3d::UnitZ();
    case DirectionWord::minus_z:
      return -Eigen::Vector3d::UnitZ();
    case DirectionWord::clockwise:
    case DirectionWord::counterclockwise:
    case DirectionWord::none:
      break;
  }
  return Eigen::Vector3d::Zero();
}

Eigen::Vector3d SceneGeometry::turning_axis(DirectionWord word) const {
  switch (word) {
    case DirectionWord::left:
    case DirectionWord::counterclockwise:
      return up;
    case DirectionWord::right:
    case DirectionWord::clockwise:
      return -up;
    case DirectionWord::toward:
      return right;
    case DirectionWord::away:
      return -right;
    case DirectionWord::up:
    case DirectionWord::down:
      return Eigen::Vector3d::Zero();
    default:
      return axis(word);
  }
}

SceneGeometry measure_scene(const Scene& scene, const Inventory& inventory, const std::vector<ViewMasks>& masks) {
  SceneGeometry geometry;
  geometry.up = scene.run.placement.up_vector();
  const Camera& front = scene.views[0].camera;
  Eigen::Vector3d right = front.rotation().row(0);
  right -= right.dot(geometry.up) * geometry.up;
  // A camera rolled by a quarter turn has its right axis along up: its down axis then serves.
  if (right.norm() < 1e-3) right = Eigen::Vector3d(front.rotation().row(1)).cross(geometry.up);
  geometry.right = right.normalized();
  geometry.toward = geometry.right.cross(geometry.up);
  std::vector<const Mask*> of_thing(masks.size());
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (size_t o = 0; o < inventory.objects.size(); ++o) {
    for (size_t v = 0; v < masks.size(); ++v) of_thing[v] = &masks[v].objects[o];
    if (const std::optional<Box> box = box_of(scene.views, of_thing)) {
      geometry.boxes[inventory.objects[o].id] = *box;
      low = low.cwiseMin(box->center - box->half);
      high = high.cwiseMax(box->center + box->half);
    }
  }
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    for (size_t v = 0; v < masks.size(); ++v) of_thing[v] = &masks[v].rows[r];
    if (const std::optional<Box> box = box_of(scene.views, of_thing)) geometry.boxes[inventory.rows[r].key()] = *box;
  }
  const double longest = geometry.boxes.empty() ? 0 : (high - low).maxCoeff();
  if (longest > 0 && std::isfinite(longest)) geometry.solver_per_scene = scene.run.placement.extent / longest;
  return geometry;
}

}  // namespace physmas::plan
