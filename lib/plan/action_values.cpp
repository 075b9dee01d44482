#include "plan/action_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace physmas::plan {
namespace {

// A mover that hits something is driven until its front has gone this share of the target's depth into it.
constexpr double kContactDepth = 0.25;
// Shortest driven approach, seconds: less would be a kick.
constexpr double kShortestApproach = 0.1;

}  // namespace

Eigen::Vector3d said_direction(const Event& event, const SceneGeometry& geometry) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const DirectionWord word : event.directions) sum += geometry.axis(word);
  return sum;
}

Eigen::Vector3d own_direction(const Event& event, ActionType type, const SceneGeometry& geometry) {
  switch (type) {
    case ActionType::top_press:
    case ActionType::vertical_compress:
    case ActionType::support_hold:
      return -geometry.up;
    case ActionType::radial_spread:
      return geometry.up;
    case ActionType::torque: {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const DirectionWord word : event.directions) sum += geometry.turning_axis(word);
      return sum.norm() > 1e-6 ? Eigen::Vector3d(sum.normalized()) : geometry.up;
    }
    case ActionType::scale:
    case ActionType::side_compress: {
      const Eigen::Vector3d sum = said_direction(event, geometry);
      return sum.norm() > 1e-6 ? Eigen::Vector3d(sum.normalized()) : geometry.right;
    }
    default:
      return Eigen::Vector3d::Zero();
  }
}

double wanted_magnitude(const Event& event, ActionType type) {
  const ActionLine& range = action_line(type);
  if (is_ratio(type)) {
    double change = (range.magnitude - 1) * event.strength;
    // To two thirds is as much as to one and a half.
    if (type == ActionType::scale && event.verb.direction == "in") change = 1 / (1 + change) - 1;
    return 1 + change;
  }
  if (event.speed && type != ActionType::torque) return *event.speed;
  return range.magnitude * event.strength;
}

double bounded_magnitude(ActionType type, double wanted, std::vector<std::string>& corrections) {
  const ActionLine& range = action_line(type);
  const double magnitude = std::min(std::max(wanted, range.min), range.max);
  if (magnitude != wanted && type != ActionType::support_hold) {
    const char* unit = range.unit;
    corrections.push_back(fmt::format("{} of {}{} brought to {}{} (bounds {}..{})", action_name(type), wanted, unit,
                                      magnitude, unit, range.min, range.max));
  }
  return magnitude;
}

double contact_time(const PlanAction& action, const SceneGeometry& geometry, double otherwise) {
  const auto a = geometry.boxes.find(action.source), b = geometry.boxes.find(action.target);
  if (a == geometry.boxes.end() || b == geometry.boxes.end() || !(geometry.solver_per_scene > 0)) return otherwise;
  const Eigen::Vector3d along = action.direction.cwiseAbs();
  const double depth = 2 * b->second.half.dot(along);
  const double apart = (b->second.center - a->second.center).dot(action.direction);
  const double gap = std::max(0.0, apart - a->second.half.dot(along) - 0.5 * depth);
  const double way = geometry.solver_per_scene * (gap + kContactDepth * depth);
  return std::min(std::max(way / action.magnitude, kShortestApproach), otherwise);
}

}  // namespace physmas::plan
