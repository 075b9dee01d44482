#include "mpm/action/collider.h"

namespace physmas::mpm {

bool near_obstacle(const Domain& domain, const int* first, int nodes) {
  const double dx = domain.dx();
  const int last_free = domain.n - domain.wall_cells;
  Vec3d center{};
  for (int axis = 0; axis < 3; ++axis) {
    if (first[axis] <= domain.wall_cells || first[axis] + nodes - 1 >= last_free) return true;
    center[axis] = (first[axis] + 0.5 * (nodes - 1)) * dx;
  }
  const double reach = 0.5 * (nodes - 1) * std::sqrt(3.0) * dx * (1 + 1e-9);
  for (const Collider& c : domain.colliders) {
    if (locate(c, center).distance <= reach) return true;
  }
  return false;
}

}  // namespace physmas::mpm
