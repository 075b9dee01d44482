#include "bundle/pattern.h"

#include <algorithm>
#include <cmath>

#include "base/constants.h"

namespace physmas::bundle {
namespace {

using Eigen::Vector3d;

double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// A value in [0, 1) for a lattice point (splitmix64 finaliser).
double lattice_value(int64_t x, int64_t y, int64_t z, uint64_t seed) {
  uint64_t h = seed + 0x9e3779b97f4a7c15u * static_cast<uint64_t>(x) + 0xbf58476d1ce4e5b9u * static_cast<uint64_t>(y) +
               0x94d049bb133111ebu * static_cast<uint64_t>(z);
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1p-53;
}

// Value noise: lattice values, blended smoothly.
double noise(const Vector3d& p, uint64_t seed) {
  const Vector3d base = p.array().floor();
  const Vector3d t = (p - base).unaryExpr([](double s) { return smooth(s); });
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight = (dx ? t.x() : 1 - t.x()) * (dy ? t.y() : 1 - t.y()) * (dz ? t.z() : 1 - t.z());
    sum += weight * lattice_value(static_cast<int64_t>(base.x()) + dx, static_cast<int64_t>(base.y()) + dy,
                                  static_cast<int64_t>(base.z()) + dz, seed);
  }
  return sum;
}

// Distance of x to the nearest whole number, 0..0.5.
double to_whole(double x) {
  return std::abs(x - std::round(x));
}

// 1 on a line, 0 away from it, with a soft edge that hides how coarse the samples are.
double line(double distance, double half_width) {
  return smooth(1.5 - distance / half_width);
}

// Distance on the unit sphere to the ribs of a basketball: two great circles, and a curve around each end of the x
// axis.
double to_seam(const Vector3d& direction) {
  const double curve = std::abs(direction.x()) - (0.42 + 0.38 * direction.z() * direction.z());
  return std::min({std::abs(direction.z()), std::abs(direction.x()), std::abs(curve)});
}

}  // namespace

Vector3d pattern_color(const ExampleShape& shape, const SurfaceSample& sample, const Vector3d& low,
                       const Vector3d& high, uint64_t noise_seed, Random& random) {
  Vector3d color = shape.color;
  if (shape.pattern) {
    using Type = ExampleShape::Pattern::Type;
    const ExampleShape::Pattern& pattern = *shape.pattern;
    const Vector3d extent = (high - low).cwiseMax(1e-9);
    const Vector3d& p = sample.position;
    const double level = shape.type == ExampleShape::Type::leaf || shape.type == ExampleShape::Type::tube
                             ? sample.u
                             : (p.z() - low.z()) / extent.z();
    double mix = 0;
    switch (pattern.type) {
      case Type::bands:
        mix = level * pattern.count - std::floor(level * pattern.count) < pattern.amount ? 1 : 0;
        break;
      case Type::spots:
        mix = random.uniform() < pattern.amount ? 1 : 0;
        break;
      case Type::noise:
        mix = pattern.amount * smooth(2 * noise((p - low) * (pattern.count / extent.maxCoeff()), noise_seed) - 0.5);
        break;
      case Type::gradient:
        mix = pattern.amount * smooth(level);
        break;
      case Type::lattice: {
        // Two families of helices; the cells between them are about as high as they are wide.
        const double turn = std::atan2(p.y(), p.x()) / (2 * kPi) * pattern.count;
        const double rise = level * pattern.count * extent.z() / (kPi * std::max(extent.x(), extent.y()));
        mix = line(std::min(to_whole(turn + rise), to_whole(turn - rise)), 0.5 * pattern.amount);
        break;
      }
      case Type::seams:
        mix = line(to_seam((p - 0.5 * (low + high)).normalized()), 0.1 * pattern.amount);
        break;
    }
    color += mix * (pattern.color - color);
  }
  return color * (1 + shape.color_jitter * random.symmetric());
}

Vector3d lit_color(const Vector3d& color, const Vector3d& normal, double gloss) {
  static const Vector3d kKey = Vector3d(-0.45, -0.65, 0.75).normalized(), kFill = Vector3d(0.6, 0.7, 0.35).normalized();
  const double sky = 0.5 + 0.5 * normal.z();
  const double light =
      0.54 + 0.18 * sky + 0.30 * std::max(0.0, normal.dot(kKey)) + 0.14 * std::max(0.0, normal.dot(kFill));
  const double highlight = gloss * std::pow(std::max(0.0, normal.dot(kKey)), 24);
  return (color * light + Vector3d::Constant(highlight)).cwiseMax(0).cwiseMin(1);
}

}  // namespace physmas::bundle
