#include "bundle/dense_component.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "scene/neighbors.h"

namespace physmas::bundle {
namespace {

constexpr size_t kSamples = 20000;
constexpr int kNeighbours = 4;
constexpr double kCubeEdge = 6;      // edge of a cube in distances to the fourth neighbour
constexpr size_t kBridge = 3;        // Gaussians of a cube that joins others: a stray is the end of a component
constexpr double kFarAround = 3;     // the whole scene's box over the component's: worth a warning
constexpr double kWorthShare = 0.2;  // of the opacities: a smaller component is no object
constexpr int kMostCubes = 1 << 20;  // per axis

// The edge of the cubes: from the distances that a quarter of the Gaussians do not exceed, so that neither a sky nor
// strays count. 0: all lie in one place.
double cube_edge(const Gaussians& g, const Eigen::Vector3d& size) {
  if (g.size() <= kNeighbours) return 0;
  std::vector<int32_t> all(g.size());
  std::iota(all.begin(), all.end(), 0);
  const NeighborSearch<3> search(g.position, std::move(all));
  const size_t step = std::max<size_t>(1, g.size() / kSamples);
  std::vector<double> distances((g.size() + step - 1) / step);
#pragma omp parallel for schedule(static)
  for (size_t k = 0; k < distances.size(); ++k)
    distances[k] = search.around(static_cast<int32_t>(k * step), kNeighbours).back().squared;
  const auto quarter = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 4);
  std::nth_element(distances.begin(), quarter, distances.end());
  return std::max(kCubeEdge * std::sqrt(*quarter), size.maxCoeff() / kMostCubes);
}

uint64_t key_of(const Eigen::Array3i& cube) {
  return (static_cast<uint64_t>(cube.x()) << 42) | (static_cast<uint64_t>(cube.y()) << 21) |
         static_cast<uint64_t>(cube.z());
}

struct Cube {
  Eigen::Array3i place;
  double opacity = 0;
  size_t count = 0;
};

}  // namespace

DenseComponent dense_component(const Gaussians& g) {
  Eigen::AlignedBox3d whole;
  for (const Eigen::Vector3f& p : g.position) whole.extend(p.cast<double>());
  DenseComponent best;
  best.box = whole;
  best.count = g.size();
  best.share = 1;
  const double edge = cube_edge(g, whole.sizes());
  if (!(edge > 0)) return best;

  const Eigen::Vector3d first = whole.min() - Eigen::Vector3d::Constant(0.5 * edge);
  std::unordered_map<uint64_t, size_t> index;
  std::vector<Cube> cubes;  // in the order in which the file comes to them
  double total = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    // Half a cube and one more are free on the lower sides: a crop takes what lies inside, and neighbours have no
    // negative places.
    const Eigen::Array3i place = ((g.position[i].cast<double>() - first) / edge).array().floor().cast<int>() + 1;
    const auto [found, added] = index.emplace(key_of(place), cubes.size());
    if (added) cubes.push_back({place});
    const double opacity = g.opacity(i);
    cubes[found->second].opacity += opacity;
    ++cubes[found->second].count;
    total += opacity;
  }
  std::vector<bool> seen(cubes.size(), false);
  std::vector<size_t> waiting;
  double most = -1;
  for (size_t start = 0; start < cubes.size(); ++start) {
    if (seen[start]) continue;
    DenseComponent component;
    double opacity = 0;
    waiting.assign(1, start);
    seen[start] = true;
    while (!waiting.empty()) {
      const Cube& cube = cubes[waiting.back()];
      waiting.pop_back();
      opacity += cube.opacity;
      component.count += cube.count;
      const Eigen::Vector3d low = first + edge * (cube.place - 1).cast<double>().matrix();
      component.box.extend(low);
      component.box.extend(low + Eigen::Vector3d::Constant(edge));
      if (cube.count < kBridge) continue;
      for (int k = 0; k < 27; ++k) {
        const Eigen::Array3i next = cube.place + Eigen::Array3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        const auto found = index.find(key_of(next));
        if (found == index.end() || seen[found->second]) continue;
        seen[found->second] = true;
        waiting.push_back(found->second);
      }
    }
    if (!(opacity > most)) continue;
    most = opacity;
    component.share = total > 0 ? opacity / total : 0;
    best = component;
  }
  return best;
}

std::string crop_text(const Eigen::AlignedBox3d& box) {
  return fmt::format("{:.4g} {:.4g} {:.4g} {:.4g} {:.4g} {:.4g}", box.min().x(), box.max().x(), box.min().y(),
                     box.max().y(), box.min().z(), box.max().z());
}

std::string surroundings_warning(const Gaussians& g, const DenseComponent& component, const Eigen::Vector3d& offset) {
  Eigen::AlignedBox3d whole;
  for (const Eigen::Vector3f& p : g.position) whole.extend(p.cast<double>());
  const double ratio = whole.sizes().maxCoeff() / component.box.sizes().maxCoeff();
  if (!(ratio > kFarAround) || component.share < kWorthShare) return "";
  return fmt::format(
      "{} of {} Gaussians lie far around the others, as a sky or a background does: the object is {:.3g} times as "
      "small "
      "in the solver as it could be; --crop auto takes it alone (--crop {})",
      g.size() - component.count, g.size(), ratio, crop_text(Eigen::AlignedBox3d(component.box).translate(offset)));
}

}  // namespace physmas::bundle
