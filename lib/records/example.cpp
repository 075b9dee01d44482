#include "records/example.h"

#include <algorithm>
#include <array>
#include <set>

#include "records/json_fields.h"
#include "records/names.h"

namespace physmas {
namespace {

using Shape = ExampleShape;

// A type's name and its own fields; the ones up to `required` must be there.
struct ShapeFields {
  const char* name;
  std::vector<const char*> fields;
  size_t required;
};

const std::vector<ShapeFields>& shape_fields() {
  static const std::vector<ShapeFields> kFields = {
      {"sphere", {"radius"}, 1},
      {"ellipsoid", {"radii"}, 1},
      {"box", {"size", "rounding"}, 1},
      {"cylinder", {"radius", "height", "rounding"}, 2},
      {"cone", {"radius", "height", "top_radius", "rounding"}, 2},
      {"torus", {"radius", "tube_radius"}, 2},
      {"disc", {"radius"}, 1},
      {"lathe", {"profile", "rounding"}, 1},
      {"tube", {"path", "radius", "top_radius"}, 2},
      {"leaf", {"length", "width", "droop"}, 2},
  };
  return kFields;
}

constexpr std::array<const char*, 11> kSizeFields = {"radius",   "top_radius", "tube_radius", "height", "radii", "size",
                                                     "rounding", "profile",    "path",        "length", "width"};
constexpr std::array<const char*, 6> kPatterns = {"bands", "spots", "noise", "gradient", "lattice", "seams"};
constexpr std::array<const char*, 3> kCopies = {"ring", "spiral", "scatter"};

void check_fields(const Json& json, const ShapeFields& type, const std::string& file, const std::string& pointer) {
  const auto takes = [&](const std::string& field) {
    return std::find(type.fields.begin(), type.fields.end(), field) != type.fields.end();
  };
  std::string list;
  for (const char* field : type.fields) list += (list.empty() ? "" : ", ") + std::string(field);
  for (size_t i = 0; i < type.required; ++i) {
    if (!json.contains(type.fields[i])) {
      throw invalid_input({file, pointer + "/" + type.fields[i], "nothing",
                           std::string("a value: a ") + type.name + " needs it", "it takes " + list});
    }
  }
  std::vector<std::string> sizes(kSizeFields.begin(), kSizeFields.end());
  sizes.push_back("droop");
  for (const std::string& field : sizes) {
    if (json.contains(field) && !takes(field)) {
      throw invalid_field(file, pointer + "/" + field, json.at(field),
                          std::string("no such field: a ") + type.name + " takes " + list);
    }
  }
}

Shape shape_from(const Json& json, double spacing, const std::string& file, const std::string& pointer) {
  Shape shape;
  const std::string type = json.at("type").get<std::string>();
  for (size_t i = 0; i < shape_fields().size(); ++i) {
    if (type == shape_fields()[i].name) shape.type = static_cast<Shape::Type>(i);
  }
  check_fields(json, shape_fields()[static_cast<size_t>(shape.type)], file, pointer);
  read_if_present(json, "radius", shape.radius);
  shape.top_radius = shape.type == Shape::Type::tube ? shape.radius : 0;
  read_if_present(json, "top_radius", shape.top_radius);
  read_if_present(json, "tube_radius", shape.tube_radius);
  read_if_present(json, "height", shape.height);
  read_if_present(json, "radii", shape.radii);
  read_if_present(json, "size", shape.size);
  read_if_present(json, "rounding", shape.rounding);
  for (const Json& p : json.value("profile", Json::array())) {
    shape.profile.emplace_back(p[0].get<double>(), p[1].get<double>());
    if (shape.profile.back().x() < 0)
      throw invalid_field(file, pointer + "/profile", p, "a radius that is not negative");
  }
  for (const Json& p : json.value("path", Json::array())) shape.path.push_back(vector3_from(p));
  read_if_present(json, "length", shape.length);
  read_if_present(json, "width", shape.width);
  read_if_present(json, "droop", shape.droop);
  read_if_present(json, "center", shape.center);
  read_if_present(json, "rotation", shape.rotation);
  shape.spacing = json.value("spacing", spacing);
  read_if_present(json, "color", shape.color);
  read_if_present(json, "color_jitter", shape.color_jitter);
  read_if_present(json, "opacity", shape.opacity);
  read_if_present(json, "gloss", shape.gloss);
  read_if_present(json, "outside_of", shape.outside_of);
  if (json.contains("pattern")) {
    const Json& p = json.at("pattern");
    Shape::Pattern pattern;
    pattern.type = static_cast<Shape::Pattern::Type>(index_of(kPatterns, p.at("type").get<std::string>()));
    read_if_present(p, "color", pattern.color);
    read_if_present(p, "count", pattern.count);
    read_if_present(p, "amount", pattern.amount);
    shape.pattern = pattern;
  }
  if (json.contains("copies")) {
    const Json& c = json.at("copies");
    Shape::Copies copies;
    copies.type = static_cast<Shape::Copies::Type>(index_of(kCopies, c.at("type").get<std::string>()));
    read_if_present(c, "count", copies.count);
    read_if_present(c, "center", copies.center);
    read_if_present(c, "rotation", copies.rotation);
    read_if_present(c, "radius", copies.radius);
    read_if_present(c, "start", copies.start);
    read_if_present(c, "tilt", copies.tilt);
    read_if_present(c, "position_jitter", copies.position_jitter);
    read_if_present(c, "rotation_jitter", copies.rotation_jitter);
    read_if_present(c, "scale_jitter", copies.scale_jitter);
    shape.copies = copies;
  }
  return shape;
}

ExampleObject object_from(const Json& json, double spacing, const std::string& file, const std::string& pointer) {
  ExampleObject object;
  object.id = json.at("id").get<std::string>();
  object.name = json.at("name").get<std::string>();
  read_if_present(json, "scene_role", object.scene_role);
  std::set<std::string> parts;
  for (size_t p = 0; p < json.at("parts").size(); ++p) {
    const Json& entry = json.at("parts")[p];
    const std::string at = pointer + "/parts/" + std::to_string(p);
    ExamplePart part;
    part.part = entry.at("part").get<std::string>();
    part.name = entry.at("name").get<std::string>();
    read_if_present(entry, "structural_role", part.structural_role);
    read_if_present(entry, "physics_group", part.physics_group);
    read_if_present(entry, "expected_labels", part.expected_labels);
    if (!parts.insert(part.part).second)
      throw invalid_field(file, at + "/part", entry.at("part"), "an id that no other part of the object has");
    for (size_t s = 0; s < entry.at("shapes").size(); ++s)
      part.shapes.push_back(shape_from(entry.at("shapes")[s], spacing, file, at + "/shapes/" + std::to_string(s)));
    object.parts.push_back(std::move(part));
  }
  for (size_t p = 0; p < object.parts.size(); ++p) {
    for (size_t s = 0; s < object.parts[p].shapes.size(); ++s) {
      for (const std::string& other : object.parts[p].shapes[s].outside_of) {
        if (parts.count(other) == 0 || other == object.parts[p].part) {
          throw invalid_field(file,
                              pointer + "/parts/" + std::to_string(p) + "/shapes/" + std::to_string(s) + "/outside_of",
                              other, "the id of another part of the object");
        }
      }
    }
  }
  return object;
}

}  // namespace

Example load_example(const std::string& path) {
  const Json document = load_record(path, "example");
  Example example;
  example.name = document.at("name").get<std::string>();
  example.prompt = document.at("prompt").get<std::string>();
  if (example.prompt.find_first_not_of(" \t\r\n") == std::string::npos)
    throw invalid_field(path, "/prompt", document.at("prompt"), "a prompt that is not blank");
  read_if_present(document, "seed", example.seed);
  read_if_present(document, "up", example.up);
  read_if_present(document, "spacing", example.spacing);
  read_if_present(document, "run", example.run);
  if (document.contains("floor")) {
    const Json& json = document.at("floor");
    Example::Floor floor;
    read_if_present(json, "height", floor.height);
    read_if_present(json, "mode", floor.mode);
    read_if_present(json, "friction", floor.friction);
    example.floor = floor;
  }
  if (document.contains("camera")) {
    const Json& json = document.at("camera");
    read_if_present(json, "azimuth", example.camera.azimuth);
    read_if_present(json, "elevation", example.camera.elevation);
    read_if_present(json, "view_elevation", example.camera.view_elevation);
    read_if_present(json, "fov", example.camera.fov);
    read_if_present(json, "margin", example.camera.margin);
    if (json.contains("frame")) {
      const Eigen::Vector3d min = vector3_from(json.at("frame").at("min")),
                            max = vector3_from(json.at("frame").at("max"));
      for (int corner = 0; corner < 8; ++corner) {
        example.camera.frame.emplace_back(corner & 1 ? max.x() : min.x(), corner & 2 ? max.y() : min.y(),
                                          corner & 4 ? max.z() : min.z());
      }
    }
  }
  std::set<std::string> ids;
  for (size_t i = 0; i < document.at("objects").size(); ++i) {
    const std::string pointer = "/objects/" + std::to_string(i);
    example.objects.push_back(object_from(document.at("objects")[i], example.spacing, path, pointer));
    if (!ids.insert(example.objects.back().id).second)
      throw invalid_field(path, pointer + "/id", example.objects.back().id, "an id that no other object has");
  }
  return example;
}

}  // namespace physmas
