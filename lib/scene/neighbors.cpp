#include "scene/neighbors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/subset_tree.h"

namespace physmas {
namespace {

// The k best by distance, then by index. nanoflann offers a point only when it is nearer than worstDist(), so that
// answers just above the worst distance that still counts: points at equal distance get through.
class OrderedResults {
 public:
  OrderedResults(size_t capacity, const std::vector<int32_t>& subset) : capacity_(capacity), subset_(subset) {}
  size_t size() const { return found_.size(); }
  bool full() const { return found_.size() == capacity_; }
  double worstDist() const { return worst_; }
  bool addPoint(double squared, uint32_t position) {
    const Neighbor offered{subset_[position], squared};
    const auto before = [](const Neighbor& a, const Neighbor& b) {
      return a.squared < b.squared || (a.squared == b.squared && a.index < b.index);
    };
    found_.insert(std::upper_bound(found_.begin(), found_.end(), offered, before), offered);
    if (found_.size() > capacity_) found_.pop_back();
    if (full()) worst_ = std::nextafter(found_.back().squared, std::numeric_limits<double>::infinity());
    return true;
  }
  std::vector<Neighbor> take() { return std::move(found_); }

 private:
  size_t capacity_;
  const std::vector<int32_t>& subset_;
  std::vector<Neighbor> found_;
  double worst_ = std::numeric_limits<double>::infinity();
};

}  // namespace

template <int Dim>
struct NeighborSearch<Dim>::Tree : SubsetTree<Dim, Point, int32_t> {
  using SubsetTree<Dim, Point, int32_t>::SubsetTree;
};

template <int Dim>
NeighborSearch<Dim>::NeighborSearch(const std::vector<Point>& points, std::vector<int32_t> subset)
    : points_(points), subset_(std::move(subset)) {
  if (!subset_.empty()) tree_ = std::make_unique<Tree>(points_, subset_);
}

template <int Dim>
NeighborSearch<Dim>::~NeighborSearch() = default;

template <int Dim>
std::vector<Neighbor> NeighborSearch<Dim>::nearest(const Point& query, int count) const {
  if (subset_.empty() || count <= 0) return {};
  OrderedResults results(std::min<size_t>(count, subset_.size()), subset_);
  const Eigen::Matrix<double, Dim, 1> q = query.template cast<double>();
  tree_->search(q.data(), results);
  return results.take();
}

template <int Dim>
std::vector<Neighbor> NeighborSearch<Dim>::around(int32_t self, int count) const {
  std::vector<Neighbor> found = nearest(points_[self], count + 1);
  const auto own = std::find_if(found.begin(), found.end(), [&](const Neighbor& n) { return n.index == self; });
  if (own != found.end()) found.erase(own);
  if (found.size() > static_cast<size_t>(count)) found.resize(count);
  return found;
}

template class NeighborSearch<3>;
template class NeighborSearch<6>;

}  // namespace physmas
