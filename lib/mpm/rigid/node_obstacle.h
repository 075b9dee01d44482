// Contact of one node with the obstacles that it lies in, and how what it does changes with the node's velocity.
#ifndef PHYSMAS_MPM_RIGID_NODE_OBSTACLE_H
#define PHYSMAS_MPM_RIGID_NODE_OBSTACLE_H

#include <vector>

#include "mpm/domain.h"

namespace physmas::mpm {

// A wall or a collider where it holds the node.
struct NodeObstacle {
  Vec3d normal = {0, 0, 1};
  Collider::Mode mode = Collider::Mode::separate;
  double friction = 0;
};

// Those of the node with this index at x [m], in the order in which they act: colliders, then walls.
void find_obstacles(const Domain& domain, const int index[3], const Vec3d& x, std::vector<NodeObstacle>& out);

// What apply_contact (action/collider.h) makes of u [m/s]; slope: du'/du.
Vec3d apply_obstacle(const NodeObstacle& obstacle, const Vec3d& u, Mat3d& slope);

// Several, one after the other.
struct NodeObstacles {
  const NodeObstacle* first = nullptr;
  int count = 0;
  Vec3d apply(Vec3d u, Mat3d& slope) const {
    slope = identity<double>();
    for (int k = 0; k < count; ++k) {
      Mat3d own;
      u = apply_obstacle(first[k], u, own);
      slope = own * slope;
    }
    return u;
  }
  Vec3d apply(const Vec3d& u) const {
    Mat3d slope;
    return apply(u, slope);
  }
};

}  // namespace physmas::mpm

#endif
