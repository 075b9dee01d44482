// lib/mpm/action/nearest.cpp without the package that it looks up a tree of.
#include "mpm/action/nearest.h"

#include <cmath>
#include <limits>

namespace physmas::mpm {

struct NearestAtRest::Tree {
  std::vector<Vec3d> points;
};

NearestAtRest::NearestAtRest(const Particles& rest, const std::vector<int>& particles)
    : tree_(std::make_unique<Tree>()) {
  for (const int i : particles) tree_->points.push_back(rest.position[i]);
}
NearestAtRest::~NearestAtRest() = default;

double NearestAtRest::squared_distance(const Vec3d& x) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3d& p : tree_->points) least = std::fmin(least, dot(p - x, p - x));
  return least;
}

}  // namespace physmas::mpm
