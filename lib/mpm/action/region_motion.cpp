#include "mpm/action/region_motion.h"

#include <cmath>

namespace physmas::mpm {

Vec3d center_of(const Places& places) {
  Vec3d sum{0, 0, 0};
  for (const Vec3d& x : places) sum = sum + x;
  return (1.0 / static_cast<double>(places.size())) * sum;
}

double mean_distance(const Places& from, const Places& to) {
  double sum = 0;
  for (size_t i = 0; i < from.size(); ++i) sum += norm(to[i] - from[i]);
  return sum / static_cast<double>(from.size());
}

double turn_about(const Vec3d& axis, const Places& from, const Places& to) {
  const Vec3d c0 = center_of(from), c1 = center_of(to);
  double sine = 0, cosine = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Vec3d a = from[i] - c0, b = to[i] - c1;
    sine += dot(axis, cross(a, b));
    cosine += dot(a, b) - dot(axis, a) * dot(axis, b);
  }
  return std::atan2(sine, cosine);
}

double stretch_along(const Vec3d& axis, const Places& from, const Places& to) {
  const double c0 = dot(axis, center_of(from)), c1 = dot(axis, center_of(to));
  double both = 0, squared = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const double a = dot(axis, from[i]) - c0;
    both += a * (dot(axis, to[i]) - c1);
    squared += a * a;
  }
  return squared > 0 ? both / squared : 1;
}

double radius_about(const Vec3d& axis, const Places& places) {
  const Vec3d c = center_of(places);
  double sum = 0;
  for (const Vec3d& x : places) {
    const Vec3d across = cross(axis, x - c);
    sum += dot(across, across);
  }
  return std::sqrt(sum / static_cast<double>(places.size()));
}

}  // namespace physmas::mpm
