#include "bundle/physgaussian_boundaries.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "records/json.h"

namespace physmas::bundle {
namespace {

using Eigen::Vector3d;

constexpr double kNoEnd = 1e3;  // seconds; PhysGaussian's "no end"

class Reader {
 public:
  Reader(const PhysGaussianFrame& frame, PhysGaussianBoundaries& result) : frame_(frame), result_(result) {}

  void read(const ForeignObject& boundary) {
    const std::string type = boundary.text("type"), pointer = boundary.where("");
    where_ = pointer.substr(0, pointer.size() - 1) + " (" + one_line(type, 40) + ")";
    if (type == "bounding_box") return;  // our walls are always there
    if (type == "surface_collider") {
      read_surface(boundary);
    } else if (type == "cuboid") {
      read_cuboid(boundary);
    } else if (type == "enforce_particle_translation") {
      const Vector3d velocity = frame_.direction(boundary.vector("velocity"));
      omit(velocity.norm() > 0 ? "the particles in a box are moved" + motion(velocity, boundary) +
                                     "; say in the prompt which part moves so (actions translation, drag_pair)"
                               : "the particles in a box are held" + interval(boundary) +
                                     "; say in the prompt which part is held (action support_hold)");
    } else if (type == "enforce_particle_velocity_rotation") {
      // PhysGaussian's second horizontal axis is the cross product of the first and the normal, so it turns about
      // -normal.
      const double rate = boundary.number("rotation_scale");
      const Vector3d axis = frame_.direction(boundary.vector("normal")).normalized() * (rate > 0 ? -1 : 1);
      omit(fmt::format(
          "the particles in a cylinder are turned about {} at {:g} rad/s{}; say in the prompt which part turns "
          "so (action torque)",
          vector_text(axis), std::abs(rate), interval(boundary)));
    } else if (type == "particle_impulse") {
      const Vector3d force = frame_.direction(boundary.vector("force"));
      omit(fmt::format(
          "the particles in a box get a force of {:g} N each along {} for {:g} steps from {:g} s; masses are not "
          "known here, so say in the prompt what is hit and how fast it gets (action impulse)",
          force.norm(), vector_text(force.normalized()), boundary.number("num_dt", 1),
          boundary.number("start_time", 0)));
    } else if (type == "release_particles_sequentially") {
      omit("layers of particles are held and let go one after the other; no action does that");
    } else {
      omit("an unknown type");
    }
  }

 private:
  void omit(const std::string& why) { result_.not_mapped.push_back({where_, why}); }

  bool lasts(const ForeignObject& boundary) const {
    return boundary.number("start_time", 0) <= 0 && boundary.number("end_time", kNoEnd) >= frame_.duration;
  }

  // " from 0.5 s to 2 s", or nothing for the whole run.
  std::string interval(const ForeignObject& boundary) const {
    if (lasts(boundary)) return "";
    return fmt::format(" from {:g} s to {:g} s", boundary.number("start_time", 0),
                       std::min(boundary.number("end_time", kNoEnd), frame_.duration));
  }

  std::string motion(const Vector3d& velocity, const ForeignObject& boundary) const {
    return fmt::format(" along {} at {:g} m/s{}", vector_text(velocity.normalized()), velocity.norm(),
                       interval(boundary));
  }

  // The axis that a unit vector lies on, else its components.
  static std::string vector_text(const Vector3d& v) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        if ((v - sign * Vector3d::Unit(axis)).norm() < 1e-6) return (sign < 0 ? "-" : "") + std::string(1, "xyz"[axis]);
      }
    }
    return fmt::format("({:.3g}, {:.3g}, {:.3g})", v.x(), v.y(), v.z());
  }

  void read_surface(const ForeignObject& boundary) {
    const std::string surface = boundary.text("surface");
    if (surface == "cut") return omit("a surface that is specific to one of PhysGaussian's scenes");
    if (surface != "sticky" && surface != "slip" && surface != "separate") {
      throw boundary.error("surface", "sticky, slip or separate");
    }
    const Vector3d normal = frame_.direction(boundary.vector("normal"));
    if (!(normal.norm() > 1e-9)) throw boundary.error("normal", "a vector that is not zero");
    const Vector3d point = frame_.point(boundary.vector("point"));
    if (!lasts(boundary)) return omit("there" + interval(boundary) + " only; colliders stay for the whole run");
    result_.colliders.push_back({{"type", "plane"},
                                 {"point", to_json(point)},
                                 {"normal", to_json(Vector3d(normal.normalized()))},
                                 {"mode", surface},
                                 {"friction", std::max(0.0, boundary.number("friction", 0))}});
  }

  // size: half the edges.
  void read_cuboid(const ForeignObject& boundary) {
    const Vector3d middle = boundary.vector("point"), half = boundary.vector("size");
    if (!(half.array() > 0).all()) throw boundary.error("size", "three numbers above 0");
    const Vector3d velocity = frame_.direction(boundary.vector("velocity"));
    if (velocity.norm() > 0) {
      return omit("a box that moves" + motion(velocity, boundary) +
                  "; colliders stay where they are: say in the prompt what it does (actions top_press, translation)");
    }
    if (!lasts(boundary)) return omit("there" + interval(boundary) + " only; colliders stay for the whole run");
    Eigen::AlignedBox3d box;
    box.extend(frame_.point(middle - half));
    box.extend(frame_.point(middle + half));
    result_.colliders.push_back({{"type", "box"},
                                 {"min", to_json(Vector3d(box.min()))},
                                 {"max", to_json(Vector3d(box.max()))},
                                 {"mode", "sticky"}});
  }

  const PhysGaussianFrame& frame_;
  PhysGaussianBoundaries& result_;
  std::string where_;
};

}  // namespace

PhysGaussianBoundaries physgaussian_boundaries(const ForeignObject& config, const PhysGaussianFrame& frame) {
  PhysGaussianBoundaries result;
  if (!config.has("boundary_conditions")) return result;
  const Json& list = config.json().at("boundary_conditions");
  if (!list.is_array()) throw config.error("boundary_conditions", "a list");
  Reader reader(frame, result);
  for (size_t i = 0; i < list.size(); ++i)
    reader.read(ForeignObject(list[i], config.file(), fmt::format("/boundary_conditions/{}", i)));
  return result;
}

}  // namespace physmas::bundle
