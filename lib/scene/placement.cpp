#include "scene/placement.h"

#include <algorithm>
#include <limits>

namespace physmas {

SolverMap solver_map(const Gaussians& gaussians, const RunSpecification& run) {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (const Eigen::Vector3f& p : gaussians.position) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d center = 0.5 * (low.cast<double>() + high.cast<double>());
  const double longest = (high.cast<double>() - low.cast<double>()).maxCoeff();
  SolverMap map;
  map.s = longest > 0 ? run.placement.extent / longest : 1;
  map.d = run.placement.center - map.s * center;
  map.length = run.grid.length;
  map.n = run.grid.n;
  return map;
}

Heights heights_of(const Gaussians& gaussians, const RunSpecification& run) {
  const SolverMap map = solver_map(gaussians, run);
  const Eigen::Vector3d up = run.placement.up_vector();
  Heights heights = {std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
  for (const Eigen::Vector3f& p : gaussians.position) {
    const double h = up.dot(map.to_solver(p.cast<double>()));
    heights.lowest = std::min(heights.lowest, h);
    heights.highest = std::max(heights.highest, h);
  }
  return heights;
}

Heights wall_heights(const RunSpecification& run) {
  const double wall = run.walls * run.grid.dx(), far = run.grid.length - wall;
  if (run.placement.up_vector().sum() > 0) return {wall, far};
  return {-far, -wall};
}

RunSpecification::Collider floor_at(double height, const RunSpecification& run) {
  RunSpecification::Collider floor;
  floor.type = RunSpecification::Collider::Type::plane;
  floor.mode = RunSpecification::Collider::Mode::separate;
  floor.normal = run.placement.up_vector();
  // In the middle of the cube, so that a person who reads the number sees a point of the domain.
  floor.point.setConstant(0.5 * run.grid.length);
  floor.point += (height - floor.normal.dot(floor.point)) * floor.normal;
  return floor;
}

}  // namespace physmas
