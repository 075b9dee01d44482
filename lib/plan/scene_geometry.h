// Where things are, as far as calibrated masks tell: what directions such as "towards the cake" need.
#ifndef PHYSMAS_PLAN_SCENE_GEOMETRY_H
#define PHYSMAS_PLAN_SCENE_GEOMETRY_H

#include <map>
#include <string>

#include "plan/vocabulary.h"
#include "records/inventory.h"
#include "records/masks.h"
#include "records/scene.h"

namespace physmas::plan {

struct Box {
  Eigen::Vector3d center, half;  // scene units, scene axes
};

struct SceneGeometry {
  Eigen::Vector3d up, right, toward;  // scene axes, unit, orthogonal; toward points out of the front view's image
  std::map<std::string, Box> boxes;   // by object id and row key; absent when fewer than two views show it
  double solver_per_scene = 0;        // estimate of the map's scale s; 0 when nothing could be measured
  // Where a word points to; zero for words of rotation.
  Eigen::Vector3d axis(DirectionWord word) const;
  // The axis, by the right-hand rule, of something that turns that way: "to the left" is counterclockwise from above,
  // "forward" lets the top come towards the viewer, "+x" is the axis itself; zero where the word says nothing of it.
  Eigen::Vector3d turning_axis(DirectionWord word) const;
};

// Axes from placement.up and the front view (the first): right is its camera's right axis made orthogonal to up, so
// "left" is left in the front image. A box centre is the least-squares meeting point of the rays through the mask
// centroids, its size the mask's extent at that depth.
SceneGeometry measure_scene(const Scene& scene, const Inventory& inventory, const std::vector<ViewMasks>& masks);

}  // namespace physmas::plan

#endif
