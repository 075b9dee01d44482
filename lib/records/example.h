// A scene described by primitives: what `pm-scene synth` reads (schemas/example.json).
#ifndef PHYSMAS_RECORDS_EXAMPLE_H
#define PHYSMAS_RECORDS_EXAMPLE_H

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "records/json.h"

namespace physmas {

// Lengths are scene units, angles degrees, colours sRGB in 0..1. Shapes are described with z up and the front at -y.
struct ExampleShape {
  enum class Type { sphere = 0, ellipsoid, box, cylinder, cone, torus, disc, lathe, tube, leaf } type = Type::sphere;
  double radius = 0;                        // sphere, cylinder, cone (at the bottom), torus (of the ring), disc, tube
  double top_radius = 0;                    // cone; tube: at the end of the path, `radius` when absent
  double tube_radius = 0;                   // torus
  double height = 0;                        // cylinder, cone: along z, centred
  Eigen::Vector3d radii = {0, 0, 0};        // ellipsoid
  Eigen::Vector3d size = {0, 0, 0};         // box: edges
  double rounding = 0;                      // box, cylinder, cone, lathe: radius of the edges
  std::vector<Eigen::Vector2d> profile;     // lathe: radius >= 0 and height
  std::vector<Eigen::Vector3d> path;        // tube
  double length = 0, width = 0, droop = 0;  // leaf: along x from the centre, across y, and the fall of its tip

  Eigen::Vector3d center = {0, 0, 0};
  Eigen::Vector3d rotation = {0, 0, 0};  // about x, then y, then z
  double spacing = 0;                    // between neighbouring Gaussians, > 0
  Eigen::Vector3d color = {0.5, 0.5, 0.5};
  double color_jitter = 0.04;
  double opacity = 0.96;
  double gloss = 0;

  struct Pattern {
    enum class Type { bands = 0, spots, noise, gradient, lattice, seams } type = Type::bands;
    Eigen::Vector3d color = {0, 0, 0};
    double count = 8;
    double amount = 0.5;
  };
  std::optional<Pattern> pattern;

  struct Copies {
    enum class Type { ring = 0, spiral, scatter } type = Type::ring;
    int count = 1;
    Eigen::Vector3d center = {0, 0, 0};
    Eigen::Vector3d rotation = {0, 0, 0};  // of the whole arrangement
    double radius = 0;
    double start = 0, tilt = 0;
    double position_jitter = 0, rotation_jitter = 0, scale_jitter = 0;
  };
  std::optional<Copies> copies;

  std::vector<std::string> outside_of;  // part ids of the same object
};

struct ExamplePart {
  std::string part, name, structural_role, physics_group;
  std::vector<std::string> expected_labels;
  std::vector<ExampleShape> shapes;
};

struct ExampleObject {
  std::string id, name, scene_role;
  std::vector<ExamplePart> parts;
};

struct Example {
  struct Floor {
    double height = 0;  // along up
    std::string mode = "separate";
    double friction = 0.4;
  };
  struct View {
    double azimuth = 25, elevation = 18;  // of the output camera
    double view_elevation = 18;           // of the four views
    double fov = 35;
    double margin = 0.12;
    std::vector<Eigen::Vector3d> frame;  // corners of a box to keep in view, z up; empty: none
  };
  std::string name, prompt;
  uint64_t seed = 1;
  std::string up = "z";
  double spacing = 0.04;
  std::optional<Floor> floor;
  View camera;
  Json run = Json::object();  // partial run specification, already valid
  std::vector<ExampleObject> objects;
};

// Reads and validates an example. Checks what the schema cannot: unique ids, the fields that each type of shape takes,
// profiles with radii that are not negative, parts that `outside_of` names, a prompt that is not blank.
Example load_example(const std::string& path);

}  // namespace physmas

#endif
