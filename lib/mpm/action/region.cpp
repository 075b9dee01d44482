#include "mpm/action/region.h"

#include <algorithm>
#include <limits>

namespace physmas::mpm {

std::vector<int> particles_of_rows(const std::vector<int>& rows, const Particles& rest) {
  std::vector<int> found;
  for (size_t i = 0; i < rest.size(); ++i) {
    if (std::find(rows.begin(), rows.end(), rest.row[i]) != rows.end()) found.push_back(static_cast<int>(i));
  }
  return found;
}

Region select_slab(const std::vector<int>& rows, const Vec3d& towards, double fraction, const Particles& rest) {
  const std::vector<int> candidates = particles_of_rows(rows, rest);
  Region region;
  if (candidates.empty()) return region;
  const Vec3d axis = (1 / norm(towards)) * towards;
  region.extent = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const int i : candidates) {
    const double at = dot(axis, rest.position[i]);
    region.extent.low = std::min(region.extent.low, at);
    region.extent.high = std::max(region.extent.high, at);
  }
  const double border = region.extent.high - fraction * region.extent.length();
  Vec3d sum{0, 0, 0};
  for (const int i : candidates) {
    // Rounding of the border must not leave the last particle out of whole rows.
    if (fraction < 1 && dot(axis, rest.position[i]) < border) continue;
    region.particles.push_back(i);
    sum = sum + rest.position[i];
  }
  region.center = (1.0 / static_cast<double>(region.particles.size())) * sum;
  for (const int i : region.particles) {
    region.radius = std::max(region.radius, norm(cross(axis, rest.position[i] - region.center)));
  }
  return region;
}

}  // namespace physmas::mpm
