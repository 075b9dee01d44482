#include "records/run_specification.h"

#include <cmath>

#include "records/run_fields.h"

namespace physmas {
namespace {

using Collider = RunSpecification::Collider;

// Writes the fields that the slices of `stages` hold.
class RunWriter {
 public:
  explicit RunWriter(unsigned stages) : stages_(stages) {}
  void section(const char* name, unsigned stages, const char*) { section_ = name, section_stages_ = stages; }
  void top() { section_ = nullptr, section_stages_ = 0; }
  template <class T>
  void field(const char* name, const T& value, const Rule&, const char*, unsigned add_to = 0) {
    if (stages_ != kEveryStage && (stages_ & (section_stages_ | add_to)) == 0) return;
    if (!is_said(value)) return;
    (section_ == nullptr ? json_ : json_[section_])[name] = json_of(value);
  }
  Json take() { return std::move(json_); }

 private:
  template <class T>
  static Json json_of(const T& value) {
    return field_json(value);
  }
  template <class Vector>
  static Json json_of(const AlongUp<Vector>& gravity) {
    return field_json(gravity.value);
  }
  static Json json_of(const std::vector<Collider>& colliders) {
    Json list = Json::array();
    for (const Collider& collider : colliders) {
      FieldWriter writer(list.emplace_back());
      visit_fields(collider, writer, false);
    }
    return list;
  }

  unsigned stages_, section_stages_ = 0;
  const char* section_ = nullptr;
  Json json_ = Json::object();
};

Collider collider_from(const Json& json, const std::string& file, const std::string& pointer) {
  Collider c;
  FieldReader reader(json);
  visit_fields(c, reader, false);  // its type comes first, and says what its other fields are
  const int optional = static_cast<int>(json.contains("mode")) + static_cast<int>(json.contains("friction"));
  if (reader.read() != static_cast<int>(json.size()) || json.size() - optional != 3) {
    throw invalid_field(file, pointer, json,
                        std::string("a ") + kColliderTypes[static_cast<int>(c.type)] + " with exactly its own fields",
                        "plane: point, normal; box: min, max; sphere: center, radius");
  }
  if (c.type == Collider::Type::plane) {
    if (!(c.normal.norm() > 1e-9))
      throw invalid_field(file, pointer + "/normal", json.at("normal"), "a vector that is not zero");
    c.normal.normalize();
  }
  if (c.type == Collider::Type::box && !(c.max.array() > c.min.array()).all()) {
    throw invalid_field(file, pointer + "/max", json.at("max"), "a corner above /min on every axis");
  }
  return c;
}

class RunReader {
 public:
  RunReader(const Json& json, const std::string& file, const std::string& pointer)
      : json_(json), object_(&json), file_(file), pointer_(pointer) {}
  void section(const char* name, unsigned, const char*) {
    static const Json kEmpty = Json::object();
    object_ = json_.contains(name) ? &json_.at(name) : &kEmpty;
  }
  void top() { object_ = &json_; }
  template <class T>
  void field(const char* name, T&& value, const Rule&, const char*, unsigned = 0) {
    const auto at = object_->find(name);
    if (at != object_->end()) read(*at, value);
  }

 private:
  template <class T>
  void read(const Json& json, T& value) {
    read_field(json, value);
  }
  template <class Vector>
  void read(const Json& json, AlongUp<Vector>& gravity) {
    if (json.is_number()) {
      gravity.value = json.get<double>() * gravity.up;
    } else {
      read_field(json, gravity.value);
    }
  }
  void read(const Json& json, std::vector<Collider>& colliders) {
    colliders.clear();
    for (const Json& entry : json)
      colliders.push_back(collider_from(entry, file_, pointer_ + "/colliders/" + std::to_string(colliders.size())));
  }

  const Json &json_, *object_;
  const std::string &file_, &pointer_;
};

}  // namespace

Eigen::Vector3d axis_vector(const std::string& name) {
  const bool negative = !name.empty() && name[0] == '-';
  const char letter = name.size() == (negative ? 2u : 1u) ? name.back() : '?';
  if (letter < 'x' || letter > 'z')
    throw Error(ExitCode::usage, "found axis \"" + name + "\", expected x, y, z, -x, -y or -z");
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  axis[letter - 'x'] = negative ? -1 : 1;
  return axis;
}

RunSpecification run_specification_from(const Json& json, const std::string& file, const std::string& pointer) {
  RunSpecification run;
  RunReader reader(json, file, pointer);
  visit_fields(run, reader);
  // Defaults that depend on other fields, and then, again, what the file says.
  run.placement.extent = 0.5 * run.grid.length;
  run.placement.center.setConstant(0.5 * run.grid.length);
  run.gravity = -9.8 * run.placement.up_vector();
  visit_fields(run, reader);

  if (run.time.substep_dt > run.time.frame_dt) {
    throw invalid_field(file, pointer + "/time/substep_dt", run.time.substep_dt, "at most frame_dt");
  }
  if (run.time.min_substep_dt > run.time.substep_dt) {
    throw invalid_field(file, pointer + "/time/min_substep_dt", run.time.min_substep_dt, "at most substep_dt");
  }
  const double wall = run.walls * run.grid.dx();
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * run.placement.extent);
  if (((run.placement.center - half).array() < wall).any() ||
      ((run.placement.center + half).array() > run.grid.length - wall).any()) {
    throw invalid_field(file, pointer + "/placement", to_json(run).at("placement"),
                        "a cube of edge `extent` at `center` inside the walls of the solver domain",
                        "make extent smaller or move center towards the middle");
  }
  return run;
}

Json to_json(const RunSpecification& run, unsigned stages) {
  RunWriter writer(stages);
  visit_fields(run, writer);
  return writer.take();
}

Json to_json(const RunSpecification& run) {
  return to_json(run, kEveryStage);
}

}  // namespace physmas
