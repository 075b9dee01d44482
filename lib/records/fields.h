// A record's fields in one list, for its reader, its writer and its schema alike.
//
// The list of a record is a function template that calls `visitor.field(...)` once for each of its fields, in the order
// of the file:
//
//   template <class Plate, class Visitor>
//   void visit_fields(Plate& plate, Visitor& visitor) {
//     visitor.field("radius", plate.radius, kPositive, "metres");
//     visitor.field("glaze", choice(plate.glaze, kGlazes), {}, "what it is covered with");
//   }
//
// A field is an int, a double, a bool, a text, a vector of three, a list, or one of several names (`choice`). One that
// is a std::optional is written only where it was said, so that records from before there was such a field keep their
// bytes.
#ifndef PHYSMAS_RECORDS_FIELDS_H
#define PHYSMAS_RECORDS_FIELDS_H

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "records/json.h"
#include "records/names.h"

namespace physmas {

// What a schema says of a value beyond its type.
struct Rule {
  const char* definition = nullptr;  // of schemas/common.json
  // Of a number, or of each in a list.
  double minimum = -std::numeric_limits<double>::infinity(), maximum = std::numeric_limits<double>::infinity();
  bool above = false;   // the minimum itself is not allowed
  int least_items = 0;  // of a list
};
inline constexpr Rule between(double minimum, double maximum) {
  return {nullptr, minimum, maximum};
}
inline constexpr Rule at_least(double minimum, int least_items = 0) {
  return {nullptr, minimum, std::numeric_limits<double>::infinity(), false, least_items};
}
inline constexpr Rule above(double minimum, double maximum) {
  return {nullptr, minimum, maximum, true};
}
inline constexpr Rule kPositive = {"positive"}, kNotNegative = {"not_negative"}, kUnit = {"unit"}, kVec3 = {"vec3"};

// A value whose name the file has: an enumeration, a flag with two names, or a text of a closed set.
template <class T, class Names>
struct Choice {
  T& value;
  const Names& names;
};
template <class T, class Names>
Choice<T, Names> choice(T& value, const Names& names) {
  return {value, names};
}

// Whether a field has a value to write.
template <class T>
bool is_said(const T&) {
  return true;
}
template <class T>
bool is_said(const std::optional<T>& value) {
  return value.has_value();
}
template <class T, class Names>
bool is_said(const Choice<T, Names>& field) {
  return is_said(field.value);
}

// Values as JSON. Records with fields of other types add overloads.
template <class T>
Json field_json(const T& value) {
  return value;
}
inline Json field_json(const Eigen::Vector3d& value) {
  return to_json(value);
}
template <class T>
Json field_json(const std::optional<T>& value) {
  return field_json(*value);
}
template <class T, class Names>
Json field_json(const Choice<T, Names>& field) {
  if constexpr (std::is_same_v<std::remove_const_t<T>, std::string>)
    return field.value;
  else
    return field.names[static_cast<size_t>(field.value)];
}
template <class T, class Names>
Json field_json(const Choice<std::optional<T>, Names>& field) {
  return field.names[static_cast<size_t>(*field.value)];
}
template <class T, class Names>
Json field_json(const Choice<const std::optional<T>, Names>& field) {
  return field.names[static_cast<size_t>(*field.value)];
}

// Values from JSON that the schema let through.
template <class T>
void read_field(const Json& json, T& value) {
  value = json.get<T>();
}
inline void read_field(const Json& json, Eigen::Vector3d& value) {
  value = vector3_from(json);
}
template <class T>
void read_field(const Json& json, std::optional<T>& value) {
  read_field(json, value.emplace());
}
template <class T, class Names>
void read_field(const Json& json, Choice<std::optional<T>, Names>& field) {
  field.value = static_cast<T>(index_of(field.names, json.get<std::string>()));
}
template <class T, class Names>
void read_field(const Json& json, Choice<T, Names>& field) {
  if constexpr (std::is_same_v<T, std::string>)
    field.value = json.get<std::string>();
  else
    field.value = static_cast<T>(index_of(field.names, json.get<std::string>()));
}

// Writes every field into `json`.
class FieldWriter {
 public:
  explicit FieldWriter(Json& json) : json_(json) {}
  template <class T>
  void field(const char* name, const T& value, const Rule& = {}, const char* = "") {
    if (is_said(value)) json_[name] = field_json(value);
  }

 private:
  Json& json_;
};

// Reads the fields that are there; the others keep their values.
class FieldReader {
 public:
  explicit FieldReader(const Json& json) : json_(json) {}
  template <class T>
  void field(const char* name, T&& value, const Rule&, const char*) {
    const auto at = json_.find(name);
    if (at == json_.end()) return;
    read_field(*at, value);
    ++read_;
  }
  int read() const { return read_; }  // how many were there

 private:
  const Json& json_;
  int read_ = 0;
};

// What a schema says of a value: its type and its bounds.
template <class T>
Json field_schema(const T&, const Rule& rule) {
  if (rule.definition != nullptr) return {{"$ref", std::string("common.json#/definitions/") + rule.definition}};
  if constexpr (std::is_same_v<T, bool>) return {{"type", "boolean"}};
  if constexpr (std::is_same_v<T, std::string>) return {{"type", "string"}};
  Json schema = {{"type", std::is_integral_v<T> ? "integer" : "number"}};
  const auto bound = [](double value) {
    return value == static_cast<int>(value) ? Json(static_cast<int>(value)) : Json(value);
  };
  if (std::isfinite(rule.minimum)) schema[rule.above ? "exclusiveMinimum" : "minimum"] = bound(rule.minimum);
  if (std::isfinite(rule.maximum)) schema["maximum"] = bound(rule.maximum);
  return schema;
}
template <class T, size_t N>
Json field_schema(const std::array<T, N>&, const Rule& rule) {
  return {{"type", "array"}, {"minItems", N}, {"maxItems", N}, {"items", field_schema(T(), rule)}};
}
template <class T>
Json field_schema(const std::vector<T>&, const Rule& rule) {
  Json schema = {{"type", "array"}};
  if (rule.least_items > 0) schema["minItems"] = rule.least_items;
  schema["items"] = field_schema(T(), rule);
  return schema;
}
template <class T>
Json field_schema(const std::optional<T>&, const Rule& rule) {
  return field_schema(T(), rule);
}
template <class T, class Names>
Json field_schema(const Choice<T, Names>& field, const Rule&) {
  return {{"enum", field.names}};
}

// The schemas of the fields by name, as `properties` has them.
class FieldSchema {
 public:
  template <class T>
  void field(const char* name, const T& value, const Rule& rule, const char* description) {
    Json& schema = properties_[name] = Json::object();
    if (*description != '\0') schema["description"] = description;
    schema.update(field_schema(value, rule));
  }
  Json take() { return std::move(properties_); }

 private:
  Json properties_ = Json::object();
};

}  // namespace physmas

#endif
