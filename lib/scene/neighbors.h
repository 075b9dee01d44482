// Nearest Gaussians, exactly and in a fixed order.
#ifndef PHYSMAS_SCENE_NEIGHBORS_H
#define PHYSMAS_SCENE_NEIGHBORS_H

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

namespace physmas {

struct Neighbor {
  int32_t index;   // into the points that the search was made from
  double squared;  // squared distance
};

// A k-d tree over a subset of points of Dim coordinates (3: places, 6: places and looks). Distances are computed in
// double; equal distances come in order of the index, so that the answer does not depend on how the tree was cut.
// Queries may run in parallel.
template <int Dim>
class NeighborSearch {
 public:
  using Point = Eigen::Matrix<float, Dim, 1>;
  // points: must outlive the search. subset: indices into it, ascending; may be empty.
  NeighborSearch(const std::vector<Point>& points, std::vector<int32_t> subset);
  ~NeighborSearch();
  NeighborSearch(const NeighborSearch&) = delete;
  NeighborSearch& operator=(const NeighborSearch&) = delete;

  // The min(count, size of the subset) nearest, by distance, then by index.
  std::vector<Neighbor> nearest(const Point& query, int count) const;
  // As nearest(points[self], count) without `self`.
  std::vector<Neighbor> around(int32_t self, int count) const;
  // Of every point of the subset, the squared distance to its nth nearest other one, nth >= 1; in no particular order.
  // The subset has more than nth points.
  std::vector<double> squared_to_nth(int nth) const;
  bool empty() const { return subset_.empty(); }

 private:
  struct Tree;
  const std::vector<Point>& points_;
  std::vector<int32_t> subset_;
  std::unique_ptr<Tree> tree_;
};

extern template class NeighborSearch<3>;
extern template class NeighborSearch<6>;

}  // namespace physmas

#endif
