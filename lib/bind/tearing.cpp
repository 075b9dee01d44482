#include "bind/tearing.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/subset_tree.h"
#include "records/reference.h"

namespace physmas::bind {
namespace {

using mpm::Vec3d;

constexpr int kNearest = 6;
constexpr long kFewest = 8;  // bonds between two rows: fewer may be a coincidence
constexpr double kBondCells = 1.5, kBrokenCells = 2, kBrokenRatio = 3;

bool parts_by_nature(Branch branch) {
  return branch == Branch::sand || branch == Branch::snow;
}

struct Bonds {
  long all = 0, broken = 0;
};

// Of the particles of one object.
void count_bonds(const std::vector<int>& particles, const mpm::Problem& problem, const std::vector<Vec3d>& x,
                 std::map<std::pair<int, int>, Bonds>& between) {
  const std::vector<Vec3d>& rest = problem.particles.position;
  const double dx = problem.domain.dx();
  const SubsetTree<3, Vec3d, int> tree(rest, particles);
  for (const int i : particles) {
    std::uint32_t nearest[kNearest + 1];
    double squared[kNearest + 1];
    nanoflann::KNNResultSet<double, std::uint32_t> results(kNearest + 1);
    results.init(nearest, squared);
    tree.search(&rest[i].x, results);
    const int row = problem.particles.row[i];
    for (size_t k = 0; k < results.size(); ++k) {
      const int other = particles[nearest[k]];
      const double distance = std::sqrt(squared[k]);
      if (other == i || distance > kBondCells * dx) continue;
      Bonds& bonds = between[std::minmax({row, problem.particles.row[other]})];
      ++bonds.all;
      // What is not finite is not together.
      if (!(norm(x[i] - x[other]) <= std::max(kBrokenCells * dx, kBrokenRatio * distance))) ++bonds.broken;
    }
  }
}

}  // namespace

std::vector<TornRow> torn_rows(const Candidate& candidate, const mpm::Problem& problem, const std::vector<Vec3d>& x) {
  std::map<int, std::string> holding;  // rows whose particles hold together, and their objects
  for (const CandidateRow& row : candidate.rows) {
    if (!parts_by_nature(row.branch)) holding[row.row] = object_of(row.key);
  }
  std::map<std::string, std::vector<int>> objects;
  for (size_t i = 0; i < problem.particles.size(); ++i) {
    const auto object = holding.find(problem.particles.row[i]);
    if (object != holding.end()) objects[object->second].push_back(static_cast<int>(i));
  }
  std::map<std::pair<int, int>, Bonds> between;
  for (const auto& [object, particles] : objects) count_bonds(particles, problem, x, between);
  std::vector<TornRow> torn;
  for (size_t a = 0; a < candidate.rows.size(); ++a) {
    for (size_t b = a; b < candidate.rows.size(); ++b) {
      const auto bonds = between.find(std::minmax({candidate.rows[a].row, candidate.rows[b].row}));
      if (bonds == between.end()) continue;
      const double share = static_cast<double>(bonds->second.broken) / static_cast<double>(bonds->second.all);
      if (a == b && share >= kTornShare) torn.push_back({candidate.rows[a].key, "", share});
      if (a != b && share >= kOffShare && bonds->second.all >= kFewest)
        torn.push_back({candidate.rows[a].key, candidate.rows[b].key, share});
    }
  }
  return torn;
}

std::string torn_line(const TornRow& row) {
  const std::string what =
      row.from.empty()
          ? fmt::format("{} comes apart ({:.0f} % of its neighbours", row.key, 100 * row.share)
          : fmt::format("{} comes off {} ({:.0f} % of what joined them", row.key, row.from, 100 * row.share);
  return what + " are more than two cells from each other): ask for less, or give it a softer material";
}

}  // namespace physmas::bind
