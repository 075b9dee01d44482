#include "mpm/action/nearest.h"

#include <limits>

#include "base/subset_tree.h"

namespace physmas::mpm {

struct NearestAtRest::Tree : SubsetTree<3, Vec3d, int> {
  using SubsetTree::SubsetTree;
};

NearestAtRest::NearestAtRest(const Particles& rest, const std::vector<int>& particles) {
  if (!particles.empty()) tree_ = std::make_unique<Tree>(rest.position, particles);
}

NearestAtRest::~NearestAtRest() = default;

double NearestAtRest::squared_distance(const Vec3d& x) const {
  if (!tree_) return std::numeric_limits<double>::infinity();
  std::uint32_t index;
  double squared;
  nanoflann::KNNResultSet<double, std::uint32_t> result(1);
  result.init(&index, &squared);
  tree_->search(&x.x, result);
  return squared;
}

}  // namespace physmas::mpm
