#include "lift/carriers.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

#include "lift/curve.h"
#include "scene/neighbors.h"

namespace physmas::lift {
namespace {

constexpr int kLevels = 10;         // the smallest cubes have an edge of length / 2^10
constexpr double kNearest = 1e-12;  // squared distance that is added, so that a Gaussian may lie on a carrier

struct Place {
  int32_t row;
  uint64_t code;  // on the curve, at the finest level
  int32_t gaussian;
};

// Rows one after the other, each along the curve.
std::vector<Place> in_order(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& row, double length) {
  constexpr int kCubes = 1 << kLevels;
  std::vector<Place> places(means.size());
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < means.size(); ++i) {
    Eigen::Vector3i c;
    for (int a = 0; a < 3; ++a)
      c[a] = std::clamp(static_cast<int>(std::floor(means[i][a] / length * kCubes)), 0, kCubes - 1);
    places[i] = {row[i], curve_position(c), static_cast<int32_t>(i)};
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return std::tie(a.row, a.code, a.gaussian) < std::tie(b.row, b.code, b.gaussian);
  });
  return places;
}

// Whether two neighbours in the order lie in the same cube of a level: 0 is the whole solver cube.
bool same_cube(const Place& a, const Place& b, int level) {
  const int bits = 3 * (kLevels - level);
  return a.row == b.row && a.code >> bits == b.code >> bits;
}

// Where the cubes of a level begin in the order, and its end.
std::vector<size_t> cubes_of(const std::vector<Place>& places, int level) {
  std::vector<size_t> begins;
  for (size_t k = 0; k < places.size(); ++k) {
    if (k == 0 || !same_cube(places[k - 1], places[k], level)) begins.push_back(k);
  }
  begins.push_back(places.size());
  return begins;
}

// Of places[begin, end), the one nearest to their mean; the first of equal ones.
size_t middle_one(const std::vector<Place>& places, size_t begin, size_t end,
                  const std::vector<Eigen::Vector3f>& means) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (size_t k = begin; k < end; ++k) mean += means[places[k].gaussian].cast<double>();
  mean /= static_cast<double>(end - begin);
  size_t best = begin;
  double least = INFINITY;
  for (size_t k = begin; k < end; ++k) {
    const double d = (means[places[k].gaussian].cast<double>() - mean).squaredNorm();
    if (d < least) least = d, best = k;
  }
  return best;
}

}  // namespace

std::vector<int32_t> choose_carriers(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& row,
                                     size_t count, double length) {
  const std::vector<Place> places = in_order(means, row, length);
  std::vector<size_t> cubes = cubes_of(places, 0), finer;
  for (int level = 1; level <= kLevels; ++level) {
    finer = cubes_of(places, level);
    if (finer.size() - 1 > count) break;
    cubes = std::move(finer);
    finer.clear();
  }
  std::vector<uint8_t> taken(places.size(), 0);
  for (size_t c = 0; c + 1 < cubes.size(); ++c) taken[middle_one(places, cubes[c], cubes[c + 1], means)] = 1;
  // The rest from cubes that are too many to have one each, or else, where all cubes are the smallest, of any.
  std::vector<size_t> others;
  for (size_t c = 0; c + 1 < finer.size(); ++c) {
    const bool has_one =
        std::any_of(taken.begin() + finer[c], taken.begin() + finer[c + 1], [](uint8_t t) { return t != 0; });
    if (!has_one) others.push_back(middle_one(places, finer[c], finer[c + 1], means));
  }
  for (size_t k = 0; finer.empty() && k < places.size(); ++k) {
    if (taken[k] == 0) others.push_back(k);
  }
  const size_t more = count - std::min(count, cubes.size() - 1);
  for (size_t k = 0; k < others.size(); ++k) {
    if ((k + 1) * more / others.size() > k * more / others.size()) taken[others[k]] = 1;
  }
  std::vector<int32_t> chosen;
  for (size_t p = 0; p < places.size(); ++p) {
    if (taken[p] != 0) chosen.push_back(places[p].gaussian);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

Carriers carry(const std::vector<Eigen::Vector3f>& means, const std::vector<int32_t>& row,
               const std::vector<int32_t>& chosen) {
  constexpr int kPer = Carriers::kPerGaussian;
  const size_t n = means.size();
  Carriers carriers;
  carriers.gaussian = chosen;
  carriers.rest = means;
  carriers.particle.assign(n * kPer, 0);
  carriers.weight.assign(n * kPer, 0);
  std::vector<int32_t> particle_of(n, -1);
  std::vector<std::vector<int32_t>> members(*std::max_element(row.begin(), row.end()) + 1);
  for (size_t q = 0; q < chosen.size(); ++q) {
    particle_of[chosen[q]] = static_cast<int32_t>(q);
    members[row[chosen[q]]].push_back(chosen[q]);
  }
  std::vector<std::unique_ptr<NeighborSearch<3>>> searches;
  for (std::vector<int32_t>& list : members)
    searches.push_back(std::make_unique<NeighborSearch<3>>(means, std::move(list)));
#pragma omp parallel for schedule(dynamic, 1024)
  for (size_t i = 0; i < n; ++i) {
    int32_t* particle = &carriers.particle[i * kPer];
    float* weight = &carriers.weight[i * kPer];
    if (particle_of[i] >= 0) {
      std::fill_n(particle, kPer, particle_of[i]);
      weight[0] = 1;
      continue;
    }
    const std::vector<Neighbor> nearest = searches[row[i]]->nearest(means[i], kPer);
    double sum = 0;
    for (const Neighbor& neighbor : nearest) sum += 1 / (neighbor.squared + kNearest);
    for (size_t k = 0; k < nearest.size(); ++k) {
      particle[k] = particle_of[nearest[k].index];
      weight[k] = static_cast<float>(1 / (nearest[k].squared + kNearest) / sum);
    }
    // A row with fewer carriers: entries of weight 0 name one of them.
    for (size_t k = nearest.size(); k < kPer; ++k) particle[k] = particle[0];
  }
  return carriers;
}

}  // namespace physmas::lift
