#include "lift/islands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "lift/evidence.h"
#include "scene/neighbors.h"

namespace physmas::lift {
namespace {

struct Cell {
  std::array<long, 3> at;
  bool operator==(const Cell& other) const { return at == other.at; }
};
struct CellHash {
  size_t operator()(const Cell& c) const {
    size_t hash = 0;
    for (const long v : c.at) hash = hash * 1000003u ^ static_cast<size_t>(v);
    return hash;
  }
};

// Disjoint sets of the numbers below n, each named after its smallest.
class DisjointSets {
 public:
  explicit DisjointSets(size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int32_t find(int32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int32_t a, int32_t b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int32_t> parent_;
};

// The pieces of `members`, at least one, each ascending, ordered by their first one.
std::vector<std::vector<int32_t>> pieces_of(const std::vector<Eigen::Vector3f>& means,
                                            const std::vector<int32_t>& members, double edge) {
  std::unordered_map<Cell, int32_t, CellHash> first;  // position in members
  DisjointSets sets(members.size());
  std::vector<Cell> cells(members.size());
  Eigen::Vector3d low = means[members[0]].cast<double>();
  for (const int32_t i : members) low = low.cwiseMin(means[i].cast<double>());
  for (size_t m = 0; m < members.size(); ++m) {
    for (int a = 0; a < 3; ++a) cells[m].at[a] = static_cast<long>(std::floor((means[members[m]][a] - low[a]) / edge));
    const auto [at, fresh] = first.emplace(cells[m], static_cast<int32_t>(m));
    if (!fresh) sets.join(at->second, static_cast<int32_t>(m));
  }
  for (const auto& [cell, m] : first) {
    for (int k = 0; k < 27; ++k) {
      const Cell other = {{cell.at[0] + k % 3 - 1, cell.at[1] + k / 3 % 3 - 1, cell.at[2] + k / 9 - 1}};
      const auto found = first.find(other);
      if (found != first.end()) sets.join(m, found->second);
    }
  }
  std::map<int32_t, std::vector<int32_t>> pieces;
  for (size_t m = 0; m < members.size(); ++m) pieces[sets.find(static_cast<int32_t>(m))].push_back(members[m]);
  std::vector<std::vector<int32_t>> list;
  for (auto& [name, piece] : pieces) list.push_back(std::move(piece));
  return list;
}

double median_spacing(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& members) {
  if (members.size() < 2) return 0;
  std::vector<double> squared = NeighborSearch<3>(means, members).squared_to_nth(1);
  const auto middle = squared.begin() + static_cast<long>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  return std::sqrt(*middle);
}

struct Island {
  int32_t row;
  double reach;
  std::vector<int32_t> members;
};

}  // namespace

Islands join_islands(const Gaussians& gaussians, const Inventory& inventory, double cell, Labels& labels) {
  const std::vector<Eigen::Vector3f>& means = gaussians.position;
  std::vector<std::vector<int32_t>> members(inventory.rows.size());
  for (size_t i = 0; i < means.size(); ++i) members[labels.row[i]].push_back(static_cast<int32_t>(i));

  std::vector<Island> islands;
  std::vector<uint8_t> body(means.size(), 0);
  for (size_t r = 0; r < members.size(); ++r) {
    if (inventory.rows[r].residual || members[r].empty()) continue;
    const double reach = std::max(cell, 2 * median_spacing(means, members[r]));
    auto pieces = pieces_of(means, members[r], reach / 2);
    size_t largest = 0;
    for (const auto& piece : pieces) largest = std::max(largest, piece.size());
    for (auto& piece : pieces) {
      if (static_cast<double>(piece.size()) < kIslandShare * static_cast<double>(largest)) {
        islands.push_back({static_cast<int32_t>(r), reach, std::move(piece)});
      } else {
        for (const int32_t i : piece) body[i] = 1;
      }
    }
  }
  Islands report;
  if (islands.empty()) return report;

  std::vector<int32_t> bodies;
  for (size_t i = 0; i < body.size(); ++i) {
    if (body[i] != 0) bodies.push_back(static_cast<int32_t>(i));
  }
  const NeighborSearch<3> search(means, bodies);
  struct Tally {
    long pieces = 0, gaussians = 0;
  };
  std::map<std::pair<int32_t, int32_t>, Tally> tallies;  // from row to row; to -1: apart
  for (const Island& island : islands) {
    std::vector<long> touched(inventory.rows.size(), 0);
    for (const int32_t i : island.members) {
      const Neighbor nearest = search.nearest(means[i], 1).front();
      if (nearest.squared <= island.reach * island.reach) ++touched[labels.row[nearest.index]];
    }
    const auto most = std::max_element(touched.begin(), touched.end());
    if (*most > 0 && touched[island.row] == *most) continue;
    const int32_t to = *most > 0 ? static_cast<int32_t>(most - touched.begin()) : -1;
    Tally& tally = tallies[{island.row, to}];
    ++tally.pieces;
    tally.gaussians += static_cast<long>(island.members.size());
    if (to < 0) continue;
    for (const int32_t i : island.members) {
      labels.row[i] = to;
      labels.object[i] = inventory.object_of_row(to);
      labels.confidence[i] = std::min(labels.confidence[i], static_cast<float>(kResidualConfidenceCap));
    }
  }
  for (const auto& [rows, tally] : tallies) {
    const auto& [from, to] = rows;
    const std::string what = "islands of " + inventory.row_keys()[from];
    const std::string count =
        fmt::format("Gaussians in small pieces apart from it: {} ({} pieces)", tally.gaussians, tally.pieces);
    report.omitted.push_back(
        {what, to < 0 ? count + ", left, as they touch nothing" : count + ", given to " + inventory.row_keys()[to]});
    (to < 0 ? report.apart : report.given) += tally.gaussians;
    (to < 0 ? report.apart_pieces : report.given_pieces) += tally.pieces;
  }
  return report;
}

}  // namespace physmas::lift
