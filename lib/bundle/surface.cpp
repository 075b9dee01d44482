#include "bundle/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/constants.h"

namespace physmas::bundle {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polyline = std::vector<Vector2d>;

constexpr double kDifference = 1e-3;  // step of the finite differences in u and v
// Products such as height / spacing that are whole numbers on paper must not fall on either side by rounding.
constexpr double kSlack = 1e-9;

// A curve through points that is walked at constant speed.
class Walk {
 public:
  explicit Walk(Polyline points) : points_(std::move(points)), length_{0} {
    for (size_t i = 1; i < points_.size(); ++i)
      length_.push_back(length_.back() + (points_[i] - points_[i - 1]).norm());
  }
  Vector2d at(double u) const {
    const double s = std::clamp(u, 0.0, 1.0) * length_.back();
    const size_t upper = std::upper_bound(length_.begin(), length_.end(), s) - length_.begin();
    const size_t i = std::clamp<size_t>(upper, 1, points_.size() - 1);
    const double span = length_[i] - length_[i - 1];
    return points_[i - 1] + (span > 0 ? (s - length_[i - 1]) / span : 0) * (points_[i] - points_[i - 1]);
  }

 private:
  Polyline points_;
  std::vector<double> length_;
};

double turn_at(const Polyline& line, size_t i) {
  const Vector2d a = line[i] - line[i - 1], b = line[i + 1] - line[i];
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

// Corners that turn by more than this are edges of the shape.
constexpr double kSharp = 30 * kPi / 180;
// Bends above this are rounded when the author asks for it.
constexpr double kBend = 3 * kPi / 180;

Polyline rounded(const Polyline& line, double radius) {
  if (radius <= 0) return line;
  Polyline out = {line.front()};
  for (size_t i = 1; i + 1 < line.size(); ++i) {
    const double turn = turn_at(line, i);
    if (turn < kBend) {
      out.push_back(line[i]);
      continue;
    }
    const Vector2d a = line[i - 1] - line[i], b = line[i + 1] - line[i];
    const double reach = std::min({radius * std::tan(0.5 * turn), 0.49 * a.norm(), 0.49 * b.norm()});
    const Vector2d from = line[i] + reach * a.normalized(), to = line[i] + reach * b.normalized();
    constexpr int kSteps = 8;
    for (int k = 0; k <= kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps;
      out.push_back((1 - t) * (1 - t) * from + 2 * t * (1 - t) * line[i] + t * t * to);
    }
  }
  out.push_back(line.back());
  return out;
}

// Even-odd rule; the outline is closed from its last point to its first.
bool inside_outline(const Polyline& outline, const Vector2d& p) {
  bool inside = false;
  for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vector2d &a = outline[i], &b = outline[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

// The outline turned about z: one patch between each pair of sharp corners, so that rows meet the edges evenly.
Surface turned(const Polyline& outline) {
  Surface surface;
  Polyline piece = {outline.front()};
  for (size_t i = 1; i < outline.size(); ++i) {
    if ((outline[i] - outline[i - 1]).norm() > 0) piece.push_back(outline[i]);
    const bool last = i + 1 == outline.size();
    if (piece.size() >= 2 && (last || turn_at(outline, i) > kSharp)) {
      const Walk walk(piece);
      surface.patches.push_back({[walk](double u, double v) {
                                   const Vector2d p = walk.at(u);
                                   return Vector3d(p.x() * std::cos(2 * kPi * v), -p.x() * std::sin(2 * kPi * v),
                                                   p.y());
                                 },
                                 true});
      piece = {outline[i]};
    }
  }
  surface.contains = [outline](const Vector3d& p) {
    return inside_outline(outline, {std::hypot(p.x(), p.y()), p.z()});
  };
  return surface;
}

Polyline arc(const Vector2d& center, double radius, double from, double to) {
  constexpr int kSteps = 96;
  Polyline line;
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = from + (to - from) * k / kSteps;
    line.emplace_back(std::max(0.0, center.x() + radius * std::cos(angle)), center.y() + radius * std::sin(angle));
  }
  return line;
}

Surface ellipsoid(const Vector3d& radii) {
  const Walk walk(arc({0, 0}, 1, -0.5 * kPi, 0.5 * kPi));
  Surface surface;
  surface.patches.push_back({[walk, radii](double u, double v) {
                               const Vector2d p = walk.at(u);
                               return Vector3d(radii.x() * p.x() * std::cos(2 * kPi * v),
                                               -radii.y() * p.x() * std::sin(2 * kPi * v), radii.z() * p.y());
                             },
                             true});
  surface.contains = [radii](const Vector3d& p) { return p.cwiseQuotient(radii).squaredNorm() < 1; };
  return surface;
}

Surface box(const Vector3d& size, double rounding) {
  const double r = std::min(rounding, 0.499 * size.minCoeff());
  const Vector3d half = 0.5 * size, core = half - Vector3d::Constant(r);
  Surface surface;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      // b and c make a right-handed frame with the outward normal.
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      surface.patches.push_back({[=](double u, double v) {
                                   Vector3d p;
                                   p[axis] = side * half[axis];
                                   p[b] = side * (2 * u - 1) * half[b];
                                   p[c] = (2 * v - 1) * half[c];
                                   if (r <= 0) return p;
                                   const Vector3d q = p.cwiseMax(-core).cwiseMin(core);
                                   return Vector3d(q + r * (p - q).normalized());
                                 },
                                 false});
    }
  }
  surface.contains = [half](const Vector3d& p) { return (p.cwiseAbs().array() < half.array()).all(); };
  return surface;
}

// Catmull-Rom through the path's points, t in [0, 1].
Vector3d on_path(const std::vector<Vector3d>& path, double t) {
  const int spans = static_cast<int>(path.size()) - 1;
  const int i = std::clamp(static_cast<int>(t * spans), 0, spans - 1);
  const double s = t * spans - i;
  const Vector3d &p1 = path[i], &p2 = path[i + 1];
  const Vector3d p0 = i > 0 ? path[i - 1] : Vector3d(2 * p1 - p2),
                 p3 = i + 2 <= spans ? path[i + 2] : Vector3d(2 * p2 - p1);
  return 0.5 *
         (2 * p1 + (p2 - p0) * s + (2 * p0 - 5 * p1 + 4 * p2 - p3) * s * s + (3 * p1 - p0 - 3 * p2 + p3) * s * s * s);
}

Surface tube(const std::vector<Vector3d>& path, double radius, double end_radius) {
  Surface surface;
  surface.patches.push_back(
      {[=](double u, double v) {
         const Vector3d tangent =
             (on_path(path, std::min(1.0, u + kDifference)) - on_path(path, std::max(0.0, u - kDifference)))
                 .normalized();
         // Any fixed direction that the path does not follow gives a frame without twist.
         const Vector3d aside = std::abs(tangent.y()) < 0.9 ? Vector3d::UnitY() : Vector3d::UnitX();
         const Vector3d a = aside.cross(tangent).normalized(), b = tangent.cross(a);
         const double r = radius + (end_radius - radius) * u;
         // Clockwise about the tangent, so that d/du x d/dv points outwards.
         return Vector3d(on_path(path, u) + r * (std::cos(2 * kPi * v) * a - std::sin(2 * kPi * v) * b));
       },
       true});
  surface.contains = [=](const Vector3d& p) {
    constexpr int kSteps = 64;
    for (int k = 0; k <= kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps;
      if ((p - on_path(path, t)).norm() < radius + (end_radius - radius) * t) return true;
    }
    return false;
  };
  return surface;
}

Surface leaf(double length, double width, double droop) {
  Surface surface;
  surface.two_sided = true;
  surface.patches.push_back(
      {[=](double u, double v) {
         // Widest before the middle, a point at the tip, a narrow foot.
         const double outline = 0.12 * (1 - u) + std::sin(kPi * std::pow(u, 0.75)) * (1 - 0.15 * u);
         const double side = (2 * v - 1) * std::max(0.02, outline);
         return Vector3d(length * u, 0.5 * width * side, -droop * length * u * u + 0.12 * width * side * side);
       },
       false});
  return surface;
}

// x rounded to a count, at least `least`.
int whole(double x, int least) {
  return std::max(least, static_cast<int>(std::min(x + 0.5 + kSlack, 1e9)));
}

double row_length(const SurfacePatch& patch, double u) {
  constexpr int kSteps = 64;
  double length = 0;
  for (int k = 0; k < kSteps; ++k)
    length += (patch.at(u, (k + 1.0) / kSteps) - patch.at(u, static_cast<double>(k) / kSteps)).norm();
  return length;
}

// Cumulative lengths along u: per step the longest over a few values of v, so that rows are nowhere too far apart.
std::vector<double> column_lengths(const SurfacePatch& patch) {
  constexpr int kSteps = 256, kColumns = 8;
  std::vector<double> total = {0};
  for (int k = 0; k < kSteps; ++k) {
    double longest = 0;
    for (int c = 0; c < kColumns; ++c) {
      const double v = (c + 0.5) / kColumns;
      longest =
          std::max(longest, (patch.at((k + 1.0) / kSteps, v) - patch.at(static_cast<double>(k) / kSteps, v)).norm());
    }
    total.push_back(total.back() + longest);
  }
  return total;
}

// Where the cumulative lengths reach s, in [0, 1].
double parameter_at(const std::vector<double>& lengths, double s) {
  const size_t upper = std::upper_bound(lengths.begin(), lengths.end(), s) - lengths.begin();
  const size_t i = std::clamp<size_t>(upper, 1, lengths.size() - 1);
  const double span = lengths[i] - lengths[i - 1];
  return (i - 1 + (span > 0 ? std::clamp((s - lengths[i - 1]) / span, 0.0, 1.0) : 0)) / (lengths.size() - 1);
}

Vector3d derivative(const SurfacePatch& patch, double u, double v, bool by_u) {
  const double x = by_u ? u : v;
  const bool wraps = !by_u && patch.closed;
  const double lo = wraps ? x - kDifference : std::max(0.0, x - kDifference);
  const double hi = wraps ? x + kDifference : std::min(1.0, x + kDifference);
  const Vector3d difference =
      by_u ? Vector3d(patch.at(hi, v) - patch.at(lo, v)) : Vector3d(patch.at(u, hi) - patch.at(u, lo));
  return difference / (hi - lo);
}

}  // namespace

Surface make_surface(const ExampleShape& shape) {
  using Type = ExampleShape::Type;
  Surface surface;
  switch (shape.type) {
    case Type::sphere:
      surface = ellipsoid(Vector3d::Constant(shape.radius));
      break;
    case Type::ellipsoid:
      surface = ellipsoid(shape.radii);
      break;
    case Type::box:
      surface = box(shape.size, shape.rounding);
      break;
    case Type::cylinder:
    case Type::cone: {
      const double top = shape.type == Type::cylinder ? shape.radius : shape.top_radius, h = 0.5 * shape.height;
      Polyline outline = {{0, -h}, {shape.radius, -h}, {top, h}};
      if (top > 0) outline.emplace_back(0, h);
      surface = turned(rounded(outline, shape.rounding));
      break;
    }
    case Type::torus:
      surface = turned(arc({shape.radius, 0}, shape.tube_radius, -kPi, kPi));
      break;
    case Type::disc:
      surface = turned({{shape.radius, 0}, {0, 0}});
      surface.two_sided = true;
      surface.contains = nullptr;
      break;
    case Type::lathe:
      surface = turned(rounded(shape.profile, shape.rounding));
      break;
    case Type::tube:
      surface = tube(shape.path, shape.radius, shape.top_radius);
      break;
    case Type::leaf:
      surface = leaf(shape.length, shape.width, shape.droop);
      break;
  }
  if (!surface.contains) surface.contains = [](const Vector3d&) { return false; };
  return surface;
}

std::vector<SurfaceSample> sample_patch(const SurfacePatch& patch, double spacing, Random& random, size_t limit) {
  std::vector<SurfaceSample> samples;
  const std::vector<double> columns = column_lengths(patch);
  const int rows = whole(columns.back() / spacing, 1);
  for (int i = 0; i < rows && samples.size() <= limit; ++i) {
    const double u = parameter_at(columns, columns.back() * (i + 0.5) / rows);
    const double u_step =
        parameter_at(columns, columns.back() * (i + 1.0) / rows) - parameter_at(columns, columns.back() * i / rows);
    const int count = whole(row_length(patch, u) / spacing, patch.closed ? 3 : 1);
    const double phase = patch.closed ? random.uniform() : 0.5;
    for (int k = 0; k < count && samples.size() <= limit; ++k) {
      SurfaceSample sample;
      sample.u = u;
      sample.v = (k + phase) / count;
      sample.position = patch.at(sample.u, sample.v);
      sample.along_u = derivative(patch, sample.u, sample.v, true) * u_step;
      sample.along_v = derivative(patch, sample.u, sample.v, false) / count;
      sample.normal = sample.along_u.cross(sample.along_v).normalized();
      samples.push_back(sample);
    }
  }
  return samples;
}

}  // namespace physmas::bundle
