#include "bundle/synth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/constants.h"
#include "base/error.h"
#include "bundle/pattern.h"
#include "bundle/surface.h"
#include "bundle/view_rig.h"

namespace physmas::bundle {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kCover = 0.62;      // standard deviation by cell edge: neighbours overlap without gaps
constexpr double kThickness = 0.16;  // standard deviation across the surface by spacing
constexpr size_t kMaxGaussians = 2000000;

// A place to put a shape: p -> scale * R p + t.
struct Pose {
  Matrix3d R = Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();
  double scale = 1;
  Vector3d apply(const Vector3d& p) const { return scale * (R * p) + t; }
  Vector3d inverse(const Vector3d& p) const { return R.transpose() * (p - t) / scale; }
};

Matrix3d rotation_of(const Vector3d& degrees) {
  const Vector3d a = degrees * (kPi / 180);
  return (Eigen::AngleAxisd(a.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(a.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(a.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

std::vector<Pose> poses_of(const ExampleShape& shape, Random& random) {
  Pose own;
  own.R = rotation_of(shape.rotation);
  own.t = shape.center;
  if (!shape.copies) return {own};
  using Type = ExampleShape::Copies::Type;
  const ExampleShape::Copies& copies = *shape.copies;
  const Matrix3d turn = rotation_of(copies.rotation);
  std::vector<Pose> poses;
  for (int i = 0; i < copies.count; ++i) {
    double angle = copies.start * kPi / 180, radius = copies.radius;
    switch (copies.type) {
      case Type::ring:
        angle += 2 * kPi * i / copies.count;
        break;
      case Type::spiral:  // Vogel's sunflower
        angle += i * kPi * (3 - std::sqrt(5.0));
        radius *= std::sqrt((i + 0.5) / copies.count);
        break;
      case Type::scatter:
        angle += 2 * kPi * random.uniform();
        radius *= std::sqrt(random.uniform());
        break;
    }
    const Vector3d shake(random.symmetric(), random.symmetric(), random.symmetric());
    const Vector3d spin(random.symmetric(), random.symmetric(), random.symmetric());
    const double grow = 1 + copies.scale_jitter * random.symmetric();
    // x points outwards in each place; a positive tilt turns z towards it.
    const Matrix3d place = turn * rotation_of({0, 0, angle * 180 / kPi}) * rotation_of({0, copies.tilt, 0});
    Pose pose;
    pose.R = place * rotation_of(copies.rotation_jitter * spin) * own.R;
    pose.scale = grow;
    pose.t = copies.center + radius * (turn * Vector3d(std::cos(angle), std::sin(angle), 0)) + place * own.t +
             copies.position_jitter * shake;
    poses.push_back(pose);
  }
  return poses;
}

struct PlacedSurface {
  const ExampleShape* shape;
  Surface surface;
  std::vector<Pose> poses;
  // Whether a point of the object's space is inside one of the copies; `except` leaves one copy out.
  bool contains(const Vector3d& p, int except = -1) const {
    for (size_t i = 0; i < poses.size(); ++i) {
      if (static_cast<int>(i) != except && surface.contains(poses[i].inverse(p))) return true;
    }
    return false;
  }
};

// Every row has random numbers of its own, so that editing one part leaves the others alone.
uint64_t row_seed(uint64_t seed, const std::string& key) {
  uint64_t h = 0xcbf29ce484222325u ^ (seed * 0x9e3779b97f4a7c15u);
  for (const char c : key) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return h;
}

float rounded_value(double value) {
  return static_cast<float>(std::nearbyint(value * 0x1p20) * 0x1p-20);
}

class Builder {
 public:
  Builder(const Example& example, const std::string& file)
      : example_(example), file_(file), to_scene_(scene_axes(example.up)) {}

  SynthScene build() {
    for (size_t o = 0; o < example_.objects.size(); ++o) add_object(o);
    return std::move(out_);
  }

 private:
  void add_object(size_t o) {
    const ExampleObject& object = example_.objects[o];
    InventoryObject entry;
    entry.id = object.id;
    entry.name = object.name;
    entry.scene_role = object.scene_role;
    for (const char* view : kViewNames) entry.queries.push_back({view, object.name});
    out_.inventory.objects.push_back(entry);
    std::vector<Random> randoms;
    std::vector<std::vector<PlacedSurface>> parts;
    for (const ExamplePart& part : object.parts) {
      randoms.emplace_back(row_seed(example_.seed, object.id + "/" + part.part));
      parts.emplace_back();
      for (const ExampleShape& shape : part.shapes)
        parts.back().push_back({&shape, make_surface(shape), poses_of(shape, randoms.back())});
    }
    for (size_t p = 0; p < object.parts.size(); ++p) add_part(o, p, parts, randoms[p]);
  }

  void add_part(size_t o, size_t p, const std::vector<std::vector<PlacedSurface>>& parts, Random& random) {
    const ExampleObject& object = example_.objects[o];
    const ExamplePart& part = object.parts[p];
    const size_t first = out_.gaussians.size();
    for (size_t s = 0; s < parts[p].size(); ++s) {
      const PlacedSurface& placed = parts[p][s];
      const uint64_t noise_seed = random.bits();
      for (size_t c = 0; c < placed.poses.size(); ++c) {
        const auto hidden = [&](const Vector3d& point) {
          for (size_t other = 0; other < parts[p].size(); ++other) {
            if (parts[p][other].contains(point, other == s ? static_cast<int>(c) : -1)) return true;
          }
          for (size_t q = 0; q < parts.size(); ++q) {
            const auto& names = placed.shape->outside_of;
            if (std::find(names.begin(), names.end(), object.parts[q].part) == names.end()) continue;
            for (const PlacedSurface& other : parts[q]) {
              if (other.contains(point)) return true;
            }
          }
          return false;
        };
        add_copy(placed, placed.poses[c], hidden, noise_seed, random);
      }
    }
    if (out_.gaussians.size() == first) {
      throw invalid_input({file_, "/objects/" + std::to_string(o) + "/parts/" + std::to_string(p),
                           "a part with every surface hidden inside other shapes", "a part that can be seen"});
    }
    InventoryRow row;
    row.object = object.id;
    row.part = part.part;
    row.name = part.name;
    row.structural_role = part.structural_role;
    row.physics_group = part.physics_group;
    row.expected_labels = part.expected_labels;
    out_.row.resize(out_.gaussians.size(), static_cast<int32_t>(out_.inventory.rows.size()));
    out_.inventory.rows.push_back(std::move(row));
  }

  template <class Hidden>
  void add_copy(const PlacedSurface& placed, const Pose& pose, const Hidden& hidden, uint64_t noise_seed,
                Random& random) {
    const ExampleShape& shape = *placed.shape;
    std::vector<SurfaceSample> samples;
    for (const SurfacePatch& patch : placed.surface.patches) {
      const size_t limit = kMaxGaussians - out_.gaussians.size() - samples.size();
      const std::vector<SurfaceSample> more = sample_patch(patch, shape.spacing / pose.scale, random, limit);
      samples.insert(samples.end(), more.begin(), more.end());
      if (out_.gaussians.size() + samples.size() > kMaxGaussians) {
        throw invalid_input({file_, "/spacing", "a spacing that needs more than two million Gaussians",
                             "a larger spacing, or smaller shapes"});
      }
    }
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::max()), high = -low;
    for (const SurfaceSample& sample : samples) {
      low = low.cwiseMin(sample.position);
      high = high.cwiseMax(sample.position);
    }
    for (const SurfaceSample& sample : samples) {
      Vector3d normal = pose.R * sample.normal;
      const Vector3d color = pattern_color(shape, sample, low, high, noise_seed, random);
      const Vector3d position = pose.apply(sample.position);
      // A touching surface is not inside: only what lies clearly below another one goes.
      if (hidden(position + 0.25 * shape.spacing * normal)) continue;
      if (placed.surface.two_sided && normal.z() < 0) normal = -normal;
      add_gaussian(shape, sample, pose, position, lit_color(color, normal, shape.gloss));
    }
  }

  void add_gaussian(const ExampleShape& shape, const SurfaceSample& sample, const Pose& pose, const Vector3d& position,
                    const Vector3d& color) {
    // Axes: along v, across it within the surface, and the normal.
    const Vector3d along = (pose.R * sample.along_v).normalized(), normal = pose.R * sample.normal;
    const Vector3d across = normal.cross(along);
    const double least = 0.25 * shape.spacing;
    const Vector3d sigma(kCover * std::max(least, pose.scale * sample.along_v.norm()),
                         kCover * std::max(least, pose.scale * std::abs((pose.R * sample.along_u).dot(across))),
                         kThickness * shape.spacing);
    Matrix3d R;
    R << along, across, normal;
    Eigen::Quaterniond q(to_scene_ * R);
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    Gaussians& g = out_.gaussians;
    const size_t i = g.size();
    g.resize(i + 1, 0);
    g.position[i] = (to_scene_ * position).unaryExpr(&rounded_value);
    g.log_scale[i] = sigma.array().log().matrix().unaryExpr(&rounded_value);
    g.rotation[i] = {rounded_value(q.w()), rounded_value(q.x()), rounded_value(q.y()), rounded_value(q.z())};
    g.opacity_logit[i] = rounded_value(std::log(shape.opacity / (1 - shape.opacity)));
    g.sh[i] = color.unaryExpr([](double c) { return rounded_value((c - 0.5) / kShC0); });
  }

  const Example& example_;
  const std::string& file_;
  const Matrix3d to_scene_;
  SynthScene out_;
};

}  // namespace

SynthScene synthesize(const Example& example, const std::string& file) {
  return Builder(example, file).build();
}

}  // namespace physmas::bundle
