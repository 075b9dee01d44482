#include "mpm/rigid/node_obstacle.h"

#include <algorithm>
#include <cmath>

#include "mpm/action/collider.h"

namespace physmas::mpm {

namespace {

// a bᵀ
Mat3d outer(const Vec3d& a, const Vec3d& b) {
  return {{a.x * b, a.y * b, a.z * b}};
}

}  // namespace

void find_obstacles(const Domain& domain, const int index[3], const Vec3d& x, std::vector<NodeObstacle>& out) {
  for (const Collider& c : domain.colliders) {
    const Contact contact = locate(c, x);
    if (contact.distance <= 0) out.push_back({contact.normal, c.mode, c.friction});
  }
  for (int axis = 0; axis < 3; ++axis) {
    NodeObstacle wall;
    wall.normal = {0, 0, 0};
    if (index[axis] <= domain.wall_cells) {
      wall.normal[axis] = 1;
      out.push_back(wall);
    }
    if (index[axis] >= domain.n - domain.wall_cells) {
      wall.normal[axis] = -1;
      out.push_back(wall);
    }
  }
}

Vec3d apply_obstacle(const NodeObstacle& o, const Vec3d& u, Mat3d& slope) {
  const Mat3d nothing = diagonal(0.0, 0.0, 0.0);
  slope = nothing;
  if (o.mode == Collider::Mode::sticky) return {0, 0, 0};
  const double normal = dot(u, o.normal);
  if (normal >= 0 && o.mode == Collider::Mode::separate) {
    slope = identity<double>();
    return u;
  }
  const Vec3d t = u - normal * o.normal;
  const double speed = norm(t), loss = o.friction * std::max(0.0, -normal);
  const Mat3d across = identity<double>() - outer(o.normal, o.normal);
  if (loss == 0) {
    slope = across;
    return t;
  }
  if (speed <= loss) return {0, 0, 0};
  slope = (1 - loss / speed) * across + (loss / (speed * speed * speed)) * outer(t, t) +
          (o.friction / speed) * outer(t, o.normal);
  return (1 - loss / speed) * t;
}

}  // namespace physmas::mpm
