// The list of the run specification's fields: all that stems from it agrees.
#include "records/run_fields.h"

#include <doctest/doctest.h>

#include <functional>

#include "base/embedded_text.h"
#include "records/run_schema.h"
#include "records/validator.h"
#include "unit/input_error.h"

using namespace physmas;

namespace {

// Calls `change` with each value of the whole specification and the schema that the list makes for it.
void for_each_field(Json& whole,
                    const std::function<void(const std::string& pointer, Json&, const Json& schema)>& change) {
  const Json properties = parse_json(run_schema_text(), "run.json").at("properties");
  for (auto& [name, value] : whole.items()) {
    const Json& schema = properties.at(name);
    if (!value.is_object()) {
      change("/" + name, value, schema);
      continue;
    }
    for (auto& [field, inner] : value.items())
      change("/" + name + "/" + field, inner, schema.at("properties").at(field));
  }
}

// Another value that the field may have, whose neighbours need not change.
Json another(const Json& value, const Json& schema) {
  if (schema.contains("enum"))
    return schema.at("enum").at(0) == value ? schema.at("enum").at(1) : schema.at("enum").at(0);
  if (value.is_boolean()) return !value.get<bool>();
  if (value.is_number_integer()) return value.get<int>() + (value == schema.at("maximum") ? -1 : 1);
  if (value.is_number()) return 0.9375 * value.get<double>() + (value == 0 ? 0.5 : 0);
  if (value.is_string()) return value == "x" ? "-y" : "x";  // an axis
  Json list = value;
  for (Json& entry : list) entry = another(entry, Json::object());
  return list;
}

Json as_record(const Json& run) {
  Json document = run;
  document["schema"] = "physmas/run/1";
  return document;
}

Json specification_with_colliders() {
  Json json = to_json(RunSpecification());
  // What is not said is not written.
  CHECK_FALSE(json["render"].contains("camera"));
  json["render"].update({{"camera", "fixed"}, {"floor", "none"}, {"agents", false}});
  json["colliders"] = {
      {{"type", "plane"}, {"point", {1, 2, 3}}, {"normal", {0, 1, 0}}, {"mode", "sticky"}, {"friction", 0.25}},
      {{"type", "box"}, {"min", {1, 2, 3}}, {"max", {4, 5, 6}}, {"mode", "slip"}, {"friction", 0.5}},
      {{"type", "sphere"}, {"center", {1, 2, 3}}, {"radius", 0.75}, {"mode", "separate"}, {"friction", 0}}};
  return json;
}

}  // namespace

TEST_CASE("run: schemas/run.json is what the list makes; `make schemas` writes it") {
  CHECK(embedded_text("schemas/run.json") == run_schema_text());
}

TEST_CASE("run: every field is read, written and let through by the schema") {
  Json json = specification_with_colliders();
  const Json before = json;
  int fields = 0;
  for_each_field(json, [&](const std::string& pointer, Json& value, const Json& schema) {
    if (pointer == "/colliders") return;
    const Json other = another(value, schema);
    CAPTURE(pointer);
    CHECK(other != value);
    value = other;
    ++fields;
  });
  CHECK(fields > 40);
  CHECK_NOTHROW(validate_record(as_record(json), "run", "run.json"));
  CHECK(to_json(run_specification_from(json, "run.json", "")) == json);
  CHECK(to_json(run_specification_from(before, "run.json", "")) == before);
}

TEST_CASE("run: every field is in the slice of a stage, and slices hold nothing else") {
  const Json whole = specification_with_colliders();
  const RunSpecification run = run_specification_from(whole, "run.json", "");
  Json all = Json::object();
  for (const Stage stage : {kGround, kLift, kMaterial, kCandidates, kSimulate, kRender, kScreen})
    all.merge_patch(to_json(run, stage));
  CHECK(Json::diff(all, whole).empty());
}

TEST_CASE("run: a value of another type, or outside its bounds, is refused by its name") {
  Json json = specification_with_colliders();
  const auto refused = [&](const std::string& pointer) {
    CAPTURE(pointer);
    const std::string message = message_of([&] { validate_record(as_record(json), "run", "run.json"); });
    CHECK(message.find("run.json: " + pointer) != std::string::npos);
  };
  for_each_field(json, [&](const std::string& pointer, Json& value, const Json& schema) {
    const Json good = value;
    for (const Json& bad : {Json(Json::object()), Json(), Json("nothing that it knows")}) {
      value = bad;
      refused(pointer);
    }
    if (schema.contains("minimum")) {
      value = schema.at("minimum").get<int>() - 1;
      refused(pointer);
      value = schema.at("maximum").get<int>() + 1;
      refused(pointer);
    }
    value = good;
  });
  for (const char* section : {"grid", "time", "render"}) {
    json[section]["unknown"] = 1;
    refused(std::string("/") + section);
    json[section].erase("unknown");
  }
  json["unknown"] = 1;
  refused("/");
}

TEST_CASE("run: a collider has the fields of its type and no others") {
  const Json whole = specification_with_colliders();
  for (size_t i = 0; i < 3; ++i) {
    for (const auto& [name, value] : whole["colliders"][i].items()) {
      if (name == "type" || name == "mode" || name == "friction") continue;
      CAPTURE(name);
      Json lacking = whole, mixed = whole;
      lacking["colliders"][i].erase(name);
      mixed["colliders"][(i + 1) % 3][name] = value;
      for (const Json& json : {lacking, mixed})
        CHECK(message_of([&] { run_specification_from(json, "run.json", ""); }).find("with exactly its own fields") !=
              std::string::npos);
    }
    Json short_form = whole;
    short_form["colliders"][i].erase("mode");
    short_form["colliders"][i].erase("friction");
    const RunSpecification run = run_specification_from(short_form, "run.json", "");
    CHECK(run.colliders[i].friction == 0.4);
    CHECK(run.colliders[i].mode == RunSpecification::Collider::Mode::separate);
  }
}
