#include "records/run_schema.h"

#include "records/run_fields.h"

namespace physmas {
namespace {

Json object_schema(const std::string& description, const Json& properties) {
  Json schema = Json::object();
  if (!description.empty()) schema["description"] = description;
  schema["type"] = "object";
  schema["additionalProperties"] = false;
  schema["properties"] = properties;
  return schema;
}

// The schemas of all sections and fields.
class RunSchema {
 public:
  void section(const char* name, unsigned, const char* description) {
    properties_[name] = object_schema(description, Json::object());
    into_ = &properties_[name]["properties"];
  }
  void top() { into_ = &properties_; }
  template <class T>
  void field(const char* name, const T& value, const Rule& rule, const char* description, unsigned = 0) {
    FieldSchema schema;
    schema.field(name, value, rule, description);
    into_->update(schema.take());
  }
  template <class Vector>
  void field(const char* name, const AlongUp<Vector>&, const Rule&, const char* description, unsigned = 0) {
    (*into_)[name] = {{"description", description},
                      {"oneOf", {{{"type", "number"}}, {{"$ref", "common.json#/definitions/vec3"}}}}};
  }
  void field(const char* name, const std::vector<RunSpecification::Collider>&, const Rule&, const char*, unsigned = 0) {
    FieldSchema fields;
    RunSpecification::Collider any;
    visit_fields(any, fields, true);
    Json items = object_schema("", fields.take());
    items["required"] = {"type"};
    (*into_)[name] = {{"type", "array"}, {"maxItems", 64}, {"items", items}};
  }
  Json take() { return std::move(properties_); }

 private:
  Json properties_ = Json::object();
  Json* into_ = &properties_;
};

// One line for each value that holds no further objects.
void print(const Json& json, const std::string& indent, std::string& text) {
  const auto holds_objects = [](const Json& value) {
    for (const Json& inner : value) {
      if (inner.is_object()) return true;
    }
    return false;
  };
  const std::string inner = indent + "  ";
  if (json.is_object() && holds_objects(json)) {
    text += "{";
    const char* separator = "\n";
    for (const auto& [key, value] : json.items()) {
      text += separator + inner + Json(key).dump() + ": ";
      print(value, inner, text);
      separator = ",\n";
    }
    text += "\n" + indent + "}";
    return;
  }
  if (!json.is_structured()) {
    text += json.dump();
    return;
  }
  text += json.is_object() ? "{" : "[";
  const char* separator = "";
  for (const auto& [key, value] : json.items()) {
    text += separator + (json.is_object() ? Json(key).dump() + ": " : "");
    print(value, inner, text);
    separator = ", ";
  }
  text += json.is_object() ? "}" : "]";
}

}  // namespace

std::string run_schema_text() {
  RunSchema fields;
  RunSpecification run;
  visit_fields(run, fields);
  Json properties;
  properties["schema"] = {{"enum", {"physmas/run/1"}}};
  properties["provenance"] = {{"$ref", "common.json#/definitions/provenance"}};
  properties.update(fields.take());
  Json schema;
  schema["$schema"] = "http://json-schema.org/draft-07/schema#";
  schema["title"] =
      "The run specification: every field has a default, the paper's where it gives one (docs/artifacts.md)";
  schema.update(object_schema("", properties));
  std::string text;
  print(schema, "", text);
  return text + "\n";
}

}  // namespace physmas
