// A k-d tree over some of a list of points: the one view of our points that nanoflann gets.
#ifndef PHYSMAS_BASE_SUBSET_TREE_H
#define PHYSMAS_BASE_SUBSET_TREE_H

#include <cstdint>
#include <nanoflann.hpp>
#include <vector>

namespace physmas {

// Point: Dim coordinates by operator[]. Squared distances are computed in double.
template <int Dim, class Point, class Index>
class SubsetTree {
 public:
  // points, subset (indices into points): both must outlive the tree.
  SubsetTree(const std::vector<Point>& points, const std::vector<Index>& subset)
      : view_{points, subset}, tree_(Dim, view_, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}
  SubsetTree(const SubsetTree&) = delete;
  SubsetTree& operator=(const SubsetTree&) = delete;

  // results: a nanoflann result set whose indices are std::uint32_t, positions in `subset`. query: Dim coordinates.
  template <class Results>
  void search(const double* query, Results& results) const {
    tree_.findNeighbors(results, query, nanoflann::SearchParams());
  }

 private:
  struct View {
    const std::vector<Point>& points;
    const std::vector<Index>& subset;
    size_t kdtree_get_point_count() const { return subset.size(); }
    double kdtree_get_pt(size_t i, size_t axis) const { return points[subset[i]][static_cast<int>(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using Metric = nanoflann::L2_Simple_Adaptor<double, View>;
  View view_;
  nanoflann::KDTreeSingleIndexAdaptor<Metric, View, Dim, std::uint32_t> tree_;
};

}  // namespace physmas

#endif
