#include "scene/neighbors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>

namespace physmas {
namespace {

constexpr size_t kParts = 16, kFewestInPart = 4096;
constexpr size_t kLeaf = 16;  // points

// The k best by distance, then by index. nanoflann offers a point only when it is nearer than worstDist(), so that
// answers just above the worst distance that still counts: points at equal distance get through.
class OrderedResults {
 public:
  explicit OrderedResults(size_t capacity) : capacity_(capacity) { found_.reserve(capacity + 1); }
  size_t size() const { return found_.size(); }
  bool full() const { return found_.size() == capacity_; }
  double worstDist() const { return worst_; }
  bool add(double squared, int32_t index) {
    const Neighbor offered{index, squared};
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
  std::vector<Neighbor> found_;
  double worst_ = std::numeric_limits<double>::infinity();
};

// The order of a tree's points, as nanoflann calls it since 1.5, and before.
template <class KdTree>
auto order_of(KdTree& tree, int) -> decltype((tree.vAcc_)) {
  return tree.vAcc_;
}
template <class KdTree>
auto order_of(KdTree& tree, long) -> decltype((tree.vAcc)) {
  return tree.vAcc;
}

}  // namespace

// The points in parts that lie apart, each with a k-d tree; the trees are built side by side. Those of a leaf lie one
// after the other, and leaves that are near mostly so.
template <int Dim>
struct NeighborSearch<Dim>::Tree {
  struct Entry {
    Point point;
    int32_t index;
  };
  // What nanoflann sees of a part.
  struct View {
    const Entry* entries;
    size_t count;
    size_t kdtree_get_point_count() const { return count; }
    double kdtree_get_pt(size_t i, size_t axis) const { return entries[i].point[static_cast<int>(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using Metric = nanoflann::L2_Simple_Adaptor<double, View>;
  struct Part {
    explicit Part(std::vector<Entry>& entries, size_t begin, size_t end)
        : view{entries.data() + begin, end - begin}, tree(Dim, view, nanoflann::KDTreeSingleIndexAdaptorParams(kLeaf)) {
      // In the order of the leaves, which the tree has found.
      std::vector<Entry> sorted;
      sorted.reserve(end - begin);
      for (const uint32_t k : order_of(tree, 0)) sorted.push_back(entries[begin + k]);
      std::copy(sorted.begin(), sorted.end(), entries.begin() + static_cast<long>(begin));
      std::iota(order_of(tree, 0).begin(), order_of(tree, 0).end(), 0u);
    }
    View view;
    nanoflann::KDTreeSingleIndexAdaptor<Metric, View, Dim, uint32_t> tree;
  };

  Tree(const std::vector<Point>& points, const std::vector<int32_t>& subset) {
    entries.reserve(subset.size());
    for (const int32_t i : subset) entries.push_back({points[i], i});
    std::vector<size_t> begins = {0, entries.size()};
    while (begins.size() <= kParts && entries.size() / begins.size() >= kFewestInPart) begins = halved(begins);
    count = begins.size() - 1;
    for (int a = 0; a < Dim; ++a) low[a].fill(0), high[a].fill(0);
#pragma omp parallel for schedule(dynamic, 1)
    for (size_t p = 0; p < count; ++p) {
      const auto [from, to] = box_of(begins[p], begins[p + 1]);
      for (int a = 0; a < Dim; ++a) low[a][p] = from[a], high[a][p] = to[a];
      parts[p] = std::make_unique<Part>(entries, begins[p], begins[p + 1]);
    }
  }
  std::pair<Point, Point> box_of(size_t begin, size_t end) const {
    Point from = entries[begin].point, to = from;
    for (size_t k = begin; k < end; ++k) {
      from = from.cwiseMin(entries[k].point);
      to = to.cwiseMax(entries[k].point);
    }
    return {from, to};
  }
  // Every part cut in the middle of its longest side.
  std::vector<size_t> halved(const std::vector<size_t>& begins) {
    std::vector<size_t> finer(2 * begins.size() - 1, entries.size());
#pragma omp parallel for schedule(dynamic, 1)
    for (size_t p = 0; p < begins.size() - 1; ++p) {
      const size_t begin = begins[p], end = begins[p + 1], middle = begin + (end - begin) / 2;
      const auto [from, to] = box_of(begin, end);
      int axis = 0;
      (to - from).maxCoeff(&axis);
      const auto at = [&](size_t k) { return entries.begin() + static_cast<long>(k); };
      std::nth_element(at(begin), at(middle), at(end),
                       [&](const Entry& a, const Entry& b) { return a.point[axis] < b.point[axis]; });
      finer[2 * p] = begin;
      finer[2 * p + 1] = middle;
    }
    return finer;
  }

  void search_part(size_t part, const double* query, OrderedResults& results) const {
    const Part& p = *parts[part];
    const Entry* const entries_of = p.view.entries;
    struct Adaptor {
      OrderedResults& results;
      const Entry* entries;
      size_t size() const { return results.size(); }
      bool full() const { return results.full(); }
      double worstDist() const { return results.worstDist(); }
      bool addPoint(double squared, uint32_t position) { return results.add(squared, entries[position].index); }
    } adaptor{results, entries_of};
    p.tree.findNeighbors(adaptor, query, nanoflann::SearchParams());
  }
  void search(const Point& point, OrderedResults& results) const {
    const Eigen::Matrix<double, Dim, 1> query = point.template cast<double>();
    // No point of a part is nearer than its box, less what rounding may do.
    std::array<double, kParts> squared{};
    for (int a = 0; a < Dim; ++a) {
      for (size_t p = 0; p < kParts; ++p) {
        const double outside = std::max(std::max(low[a][p] - query[a], query[a] - high[a][p]), 0.0);
        squared[p] += outside * outside;
      }
    }
    size_t nearest = 0;
    for (size_t p = 1; p < count; ++p) {
      if (squared[p] < squared[nearest]) nearest = p;
    }
    search_part(nearest, query.data(), results);
    for (size_t p = 0; p < count; ++p) {
      if (p != nearest && squared[p] * (1 - 1e-12) < results.worstDist()) search_part(p, query.data(), results);
    }
  }

  std::vector<Entry> entries;
  size_t count;  // of the parts
  std::array<std::unique_ptr<Part>, kParts> parts;
  std::array<std::array<double, kParts>, Dim> low, high;  // their boxes
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
  OrderedResults results(std::min<size_t>(count, subset_.size()));
  tree_->search(query, results);
  return results.take();
}

template <int Dim>
std::vector<double> NeighborSearch<Dim>::squared_to_nth(int nth) const {
  const Tree& tree = *tree_;
  std::vector<double> squared(subset_.size());
#pragma omp parallel for schedule(dynamic, 1024)
  for (size_t k = 0; k < squared.size(); ++k) {
    // The point itself is the first, or one of as many at its place.
    OrderedResults results(static_cast<size_t>(nth) + 1);
    tree.search(tree.entries[k].point, results);
    squared[k] = results.take().back().squared;
  }
  return squared;
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
