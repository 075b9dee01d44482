#include "lift/filling.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "lift/curve.h"

namespace physmas::lift {
namespace {

constexpr float kFaintOpacity = 0.1f;
constexpr float kReach = 1.5f;    // standard deviations that count as the Gaussian's body
constexpr int kLargestHalf = 16;  // subcells: no Gaussian reaches farther from its mean
constexpr int kRim = 3;           // subcells at the lattice's border that stay empty, so that the outside is connected
constexpr double kSolidShare = 0.95;
constexpr size_t kMostSubcells = size_t{1} << 26;

using Cells = std::vector<uint8_t>;  // one byte per subcell, 0 or 1

// A box of subcells around the scene, aligned with the solver's cells, with an empty margin.
struct Lattice {
  double h = 0;           // edge of a subcell
  int per_axis = 1;       // subcells per solver cell and axis
  Eigen::Vector3i first;  // index of the first subcell, counted from the solver's origin
  Eigen::Vector3i size;   // subcells per axis
  size_t count() const { return static_cast<size_t>(size.x()) * size.y() * size.z(); }
  size_t at(int x, int y, int z) const { return (static_cast<size_t>(z) * size.y() + y) * size.x() + x; }
  // Subcell that holds a point of solver space, clamped to the box.
  Eigen::Vector3i cell_of(const Eigen::Vector3f& p) const {
    Eigen::Vector3i c;
    for (int a = 0; a < 3; ++a) c[a] = std::clamp(static_cast<int>(std::floor(p[a] / h)) - first[a], 0, size[a] - 1);
    return c;
  }
  size_t at(const Eigen::Vector3i& c) const { return at(c.x(), c.y(), c.z()); }
  Eigen::Vector3d center(const Eigen::Vector3i& c) const {
    return h * ((c + first).cast<double>() + Eigen::Vector3d::Constant(0.5));
  }
};

Lattice make_lattice(const std::vector<Eigen::Vector3f>& means, const SolverMap& map, int per_cell) {
  Eigen::Vector3f low = means[0], high = means[0];
  for (const Eigen::Vector3f& p : means) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Lattice lattice;
  lattice.per_axis = std::max(2, static_cast<int>(std::ceil(std::cbrt(per_cell) - 1e-9)));
  for (;; --lattice.per_axis) {
    const int m = lattice.per_axis;
    lattice.h = map.length / map.n / m;
    // Whole solver cells, and room for bodies to reach out of the box of the means and for closing.
    const int margin = (2 * kRim / m + 1) * m;
    for (int a = 0; a < 3; ++a) {
      const int begin = static_cast<int>(std::floor(low[a] / lattice.h)) / m * m - margin;
      const int end = (static_cast<int>(std::floor(high[a] / lattice.h)) / m + 1) * m + margin;
      lattice.first[a] = begin;
      lattice.size[a] = end - begin;
    }
    if (m == 1 || lattice.count() <= kMostSubcells) return lattice;
  }
}

// Standard deviation that is added to every Gaussian: its body then reaches half a subcell's diagonal at least, and
// flat Gaussians mark an unbroken sheet.
double padding_of(const Lattice& lattice) {
  return 0.5 * std::sqrt(3.0) * lattice.h / kReach;
}

// Marks the subcells whose centre lies in the Gaussian's body.
void draw_gaussian(const Gaussians& gaussians, size_t i, const Eigen::Vector3f& mean, const SolverMap& map,
                   const Lattice& lattice, Cells& cells) {
  const double pad = padding_of(lattice);
  Eigen::Matrix3d S = gaussians.covariance(i).cast<double>() * (map.s * map.s);
  S.diagonal().array() += pad * pad;
  const Eigen::Matrix3d precision = S.inverse() / (kReach * kReach);
  const Eigen::Vector3i middle = lattice.cell_of(mean);
  cells[lattice.at(middle)] = 1;
  Eigen::Vector3i half;
  for (int a = 0; a < 3; ++a)
    half[a] = static_cast<int>(std::min<double>(kLargestHalf, std::ceil(kReach * std::sqrt(S(a, a)) / lattice.h)));
  const Eigen::Vector3i last = lattice.size - Eigen::Vector3i::Constant(kRim + 1);
  const Eigen::Vector3i begin = (middle - half).cwiseMax(kRim), end = (middle + half).cwiseMin(last);
  for (int z = begin.z(); z <= end.z(); ++z) {
    for (int y = begin.y(); y <= end.y(); ++y) {
      for (int x = begin.x(); x <= end.x(); ++x) {
        const Eigen::Vector3d d = lattice.center({x, y, z}) - mean.cast<double>();
        if (d.dot(precision * d) <= 1) cells[lattice.at(x, y, z)] = 1;
      }
    }
  }
}

// One pass of a 3x3x3 box maximum (value 1) or minimum (value 0), axis by axis; beyond the lattice nothing changes it.
void spread_value(const Lattice& lattice, uint8_t value, Cells& cells) {
  const size_t stride[3] = {1, static_cast<size_t>(lattice.size.x()),
                            static_cast<size_t>(lattice.size.x()) * lattice.size.y()};
  Cells before;
  for (int a = 0; a < 3; ++a) {
    before = cells;
#pragma omp parallel for schedule(static)
    for (int z = 0; z < lattice.size.z(); ++z) {
      for (int y = 0; y < lattice.size.y(); ++y) {
        for (int x = 0; x < lattice.size.x(); ++x) {
          const int along = a == 0 ? x : a == 1 ? y : z;
          const size_t c = lattice.at(x, y, z);
          if ((along > 0 && before[c - stride[a]] == value) ||
              (along + 1 < lattice.size[a] && before[c + stride[a]] == value)) {
            cells[c] = value;
          }
        }
      }
    }
  }
}

// Everything that cannot be reached from the lattice's corner through empty subcells, face to face.
Cells not_reached(const Lattice& lattice, const Cells& walls) {
  Cells inside(lattice.count(), 1);
  std::vector<size_t> stack = {0};
  inside[0] = 0;
  const size_t row = lattice.size.x(), slice = row * lattice.size.y();
  while (!stack.empty()) {
    const size_t c = stack.back();
    stack.pop_back();
    const int x = static_cast<int>(c % row), y = static_cast<int>(c / row % lattice.size.y()),
              z = static_cast<int>(c / slice);
    const auto visit = [&](bool exists, size_t next) {
      if (!exists || inside[next] == 0 || walls[next] != 0) return;
      inside[next] = 0;
      stack.push_back(next);
    };
    visit(x > 0, c - 1);
    visit(x + 1 < lattice.size.x(), c + 1);
    visit(y > 0, c - row);
    visit(y + 1 < lattice.size.y(), c + row);
    visit(z > 0, c - slice);
    visit(z + 1 < lattice.size.z(), c + slice);
  }
  return inside;
}

// Takes `layers` subcells off the surface of `cells`, by turns over faces and over faces, edges and corners, which
// comes near to a distance.
void peel(const Lattice& lattice, int layers, Cells& cells) {
  const size_t row = lattice.size.x(), slice = row * lattice.size.y();
  for (int layer = 0; layer < layers; ++layer) {
    if (layer % 2 == 1) {
      spread_value(lattice, 0, cells);
      continue;
    }
    const Cells before = cells;
#pragma omp parallel for schedule(static)
    for (int z = 1; z < lattice.size.z() - 1; ++z) {
      for (int y = 1; y < lattice.size.y() - 1; ++y) {
        for (int x = 1; x < lattice.size.x() - 1; ++x) {
          const size_t c = lattice.at(x, y, z);
          cells[c] = before[c] & before[c - 1] & before[c + 1] & before[c - row] & before[c + row] & before[c - slice] &
                     before[c + slice];
        }
      }
    }
  }
}

// How far a drawn body reaches beyond its mean across its flattest axis, in subcells: median over the object.
int body_layers(const Gaussians& gaussians, const std::vector<int32_t>& members, const SolverMap& map,
                const Lattice& lattice) {
  std::vector<double> reach;
  const double pad = padding_of(lattice);
  for (const int32_t i : members) {
    const double sigma = map.s * gaussians.scale(i).minCoeff();
    reach.push_back(kReach * std::sqrt(sigma * sigma + pad * pad));
  }
  std::nth_element(reach.begin(), reach.begin() + reach.size() / 2, reach.end());
  return static_cast<int>(std::ceil(reach[reach.size() / 2] / lattice.h));
}

// Share of the solver cells wholly in `inner` that hold one of the object's means; 1 when there is no such cell but
// the object has an interior of single subcells.
double solidity_of(const Lattice& lattice, const Cells& inner, const Cells& means) {
  const int m = lattice.per_axis;
  long whole = 0, held = 0;
#pragma omp parallel for schedule(static) reduction(+ : whole, held)
  for (int z = 0; z < lattice.size.z(); z += m) {
    for (int y = 0; y < lattice.size.y(); y += m) {
      for (int x = 0; x < lattice.size.x(); x += m) {
        bool all = true, any = false;
        for (int k = 0; k < m * m * m; ++k) {
          const size_t c = lattice.at(x + k % m, y + k / m % m, z + k / m / m);
          all = all && inner[c] != 0;
          any = any || means[c] != 0;
        }
        whole += all;
        held += all && any;
      }
    }
  }
  return whole == 0 ? 0 : static_cast<double>(held) / static_cast<double>(whole);
}

struct Interior {
  Cells inner;  // inside without what bodies on the surface reach outwards
  long cells = 0, inner_cells = 0;
};

Interior interior_of(const Lattice& lattice, const Cells& drawn, int layers) {
  Cells closed = drawn;
  spread_value(lattice, 1, closed);
  spread_value(lattice, 0, closed);
  Interior interior;
  interior.inner = not_reached(lattice, closed);
  interior.cells = std::accumulate(interior.inner.begin(), interior.inner.end(), 0L);
  peel(lattice, layers, interior.inner);
  interior.inner_cells = std::accumulate(interior.inner.begin(), interior.inner.end(), 0L);
  return interior;
}

}  // namespace

Filling fill_objects(const Gaussians& gaussians, const std::vector<Eigen::Vector3f>& means,
                     const std::vector<int32_t>& object, int objects, const SolverMap& map,
                     const RunSpecification& run) {
  const Lattice lattice = make_lattice(means, map, run.particles.per_cell);
  Filling filling;
  filling.objects.resize(objects);
  filling.spacing = lattice.h;
  Cells any_mean(lattice.count(), 0);
  for (const Eigen::Vector3f& p : means) any_mean[lattice.at(lattice.cell_of(p))] = 1;

  // owner: the object whose inside a subcell is; of several, the smallest, so that a filled glass stays filled with
  // its beverage. Subcells that another object's Gaussians take up are nobody's interior.
  std::vector<Interior> interiors(objects);
  std::vector<int32_t> drawn_by(lattice.count(), -1);
  constexpr int32_t kSeveral = -2;
  for (int o = 0; o < objects; ++o) {
    Cells drawn(lattice.count(), 0), own_means(lattice.count(), 0);
    std::vector<int32_t> members;
    for (size_t i = 0; i < means.size(); ++i) {
      if (object[i] != o) continue;
      members.push_back(static_cast<int32_t>(i));
      own_means[lattice.at(lattice.cell_of(means[i]))] = 1;
      if (gaussians.opacity(i) >= kFaintOpacity) draw_gaussian(gaussians, i, means[i], map, lattice, drawn);
    }
    if (members.empty()) continue;
    for (size_t c = 0; c < drawn.size(); ++c) {
      if (drawn[c] != 0) drawn_by[c] = drawn_by[c] == -1 ? o : kSeveral;
    }
    interiors[o] = interior_of(lattice, drawn, body_layers(gaussians, members, map, lattice));
    Filling::Report& report = filling.objects[o];
    report.cells = interiors[o].cells;
    report.volume = static_cast<double>(report.cells) * lattice.h * lattice.h * lattice.h;
    report.solidity = solidity_of(lattice, interiors[o].inner, own_means);
    using Verdict = Filling::Report::Verdict;
    report.verdict = interiors[o].inner_cells == 0    ? Verdict::open
                     : report.solidity >= kSolidShare ? Verdict::solid
                                                      : Verdict::filled;
  }
  std::vector<int> order(objects);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return interiors[a].cells < interiors[b].cells; });

  struct Site {
    uint64_t code;
    int32_t object;
    Eigen::Vector3i cell;
  };
  std::vector<Site> sites;
  Cells taken = any_mean;
  for (const int o : order) {
    if (interiors[o].inner.empty()) continue;
    const bool fill = filling.objects[o].verdict == Filling::Report::Verdict::filled;
    for (int z = 0; z < lattice.size.z(); ++z) {
      for (int y = 0; y < lattice.size.y(); ++y) {
        for (int x = 0; x < lattice.size.x(); ++x) {
          const size_t c = lattice.at(x, y, z);
          if (interiors[o].inner[c] == 0 || taken[c] != 0 || (drawn_by[c] != -1 && drawn_by[c] != o)) continue;
          taken[c] = 1;
          if (fill) sites.push_back({curve_position({x, y, z}), o, {x, y, z}});
        }
      }
    }
    interiors[o].inner = Cells();
  }
  std::sort(sites.begin(), sites.end(), [](const Site& a, const Site& b) { return a.code < b.code; });

  // Thin evenly along the curve: to the density, then to the particle limit.
  const double density = run.particles.per_cell / std::pow(lattice.per_axis, 3);
  const long wanted = std::lround(static_cast<double>(sites.size()) * std::min(1.0, density));
  const long room = run.particles.max - static_cast<long>(run.particles.simulated(means.size()));
  const long keep = std::min(wanted, room), all = static_cast<long>(sites.size());
  filling.kept = all == 0 ? 1 : static_cast<double>(keep) / static_cast<double>(all);
  std::vector<Site> kept;
  for (long k = 0; k < all; ++k) {
    if ((k + 1) * keep / all > k * keep / all) kept.push_back(sites[k]);
  }
  std::stable_sort(kept.begin(), kept.end(), [](const Site& a, const Site& b) { return a.object < b.object; });
  for (const Site& site : kept) {
    filling.position.push_back(lattice.center(site.cell).cast<float>());
    filling.object.push_back(site.object);
  }
  return filling;
}

std::vector<float> rest_volumes(const std::vector<Eigen::Vector3f>& position, const SolverMap& map) {
  const double dx = map.length / map.n;
  const auto cell_of = [&](const Eigen::Vector3f& p) {
    size_t index = 0;
    for (int a = 2; a >= 0; --a)
      index = index * map.n + std::clamp(static_cast<int>(std::floor(p[a] / dx)), 0, map.n - 1);
    return index;
  };
  std::vector<size_t> cell(position.size());
#pragma omp parallel for schedule(static)
  for (size_t q = 0; q < position.size(); ++q) cell[q] = cell_of(position[q]);
  std::vector<int32_t> count(static_cast<size_t>(map.n) * map.n * map.n, 0);
  for (const size_t c : cell) ++count[c];
  std::vector<float> volume(position.size());
#pragma omp parallel for schedule(static)
  for (size_t q = 0; q < position.size(); ++q) volume[q] = static_cast<float>(dx * dx * dx / count[cell[q]]);
  return volume;
}

}  // namespace physmas::lift
