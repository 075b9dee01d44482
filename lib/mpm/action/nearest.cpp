#include "mpm/action/nearest.h"

#include <limits>
#include <nanoflann.hpp>

namespace physmas::mpm {

namespace {

// The view of some particles' rest positions that nanoflann searches.
struct Cloud {
  const Particles& rest;
  const std::vector<int>& particles;
  size_t kdtree_get_point_count() const { return particles.size(); }
  double kdtree_get_pt(size_t i, size_t axis) const { return rest.position[particles[i]][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

}  // namespace

struct NearestAtRest::Tree {
  Cloud cloud;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3> index;
  Tree(const Particles& rest, const std::vector<int>& particles)
      : cloud{rest, particles}, index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}
};

NearestAtRest::NearestAtRest(const Particles& rest, const std::vector<int>& particles) {
  if (!particles.empty()) tree_ = std::make_unique<Tree>(rest, particles);
}

NearestAtRest::~NearestAtRest() = default;

double NearestAtRest::squared_distance(const Vec3d& x) const {
  if (!tree_) return std::numeric_limits<double>::infinity();
  size_t index;
  double squared;
  nanoflann::KNNResultSet<double> result(1);
  result.init(&index, &squared);
  tree_->index.findNeighbors(result, &x.x, nanoflann::SearchParams());
  return squared;
}

}  // namespace physmas::mpm
