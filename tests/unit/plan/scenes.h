// Scene geometry for the tests of plans.
#ifndef PHYSMAS_TESTS_PLAN_SCENES_H
#define PHYSMAS_TESTS_PLAN_SCENES_H

#include <map>
#include <string>

#include "plan/scene_geometry.h"

namespace physmas::plan {

// Up is z, right is x, the viewer stands at -y. Objects are cubes of edge 0.5 at these centres, scene units.
inline SceneGeometry cubes_at(const std::map<std::string, Eigen::Vector3d>& centers, double solver_per_scene) {
  SceneGeometry g;
  g.up = Eigen::Vector3d::UnitZ();
  g.right = Eigen::Vector3d::UnitX();
  g.toward = -Eigen::Vector3d::UnitY();
  for (const auto& [object, center] : centers) g.boxes[object] = {center, Eigen::Vector3d::Constant(0.25)};
  g.solver_per_scene = solver_per_scene;
  return g;
}

}  // namespace physmas::plan

#endif
