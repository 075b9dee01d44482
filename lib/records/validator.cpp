#include "records/validator.h"

// Else the library prints a line of its own and aborts.
#define VALIJSON_USE_EXCEPTIONS 1

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "base/embedded_text.h"
#include "base/error.h"

namespace physmas {
namespace {

using nlohmann::json;

std::string schema_text(const std::string& file) {
  return embedded_text("schemas/" + file);
}

// Schemas refer to schemas/common.json by its file name.
const json* fetch_schema(const std::string& uri) {
  const size_t slash = uri.find_last_of('/');
  return new json(json::parse(schema_text(slash == std::string::npos ? uri : uri.substr(slash + 1))));
}

void free_schema(const json* document) {
  delete document;
}

const valijson::Schema& compiled_schema(const std::string& record) {
  static std::map<std::string, std::unique_ptr<valijson::Schema>> cache;
  std::unique_ptr<valijson::Schema>& schema = cache[record];
  if (!schema) {
    schema = std::make_unique<valijson::Schema>();
    const json document = json::parse(schema_text(record + ".json"));
    valijson::SchemaParser parser;
    parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(document), *schema, fetch_schema, free_schema);
  }
  return *schema;
}

// valijson names a place as "<root>[rows][0][name]".
std::vector<std::string> steps_of(const std::vector<std::string>& context) {
  std::vector<std::string> steps;
  for (const std::string& step : context) {
    if (step == "<root>") continue;
    steps.push_back(step.size() > 2 && step.front() == '[' ? step.substr(1, step.size() - 2) : step);
  }
  return steps;
}

std::string pointer_of(const std::vector<std::string>& steps) {
  std::string pointer;
  for (const std::string& step : steps) pointer += "/" + step;
  return pointer;
}

using Schema = nlohmann::ordered_json;

// What a text must look like at a place of the document: the first pattern that its schema has there. base: the
// schema's file, for references inside it.
std::string pattern_at(const Schema& schema, const std::string& base, const std::vector<std::string>& place,
                       size_t step, int depth = 0) {
  if (!schema.is_object() || depth > 64) return "";
  if (schema.contains("$ref")) {
    const std::string reference = schema.at("$ref").get<std::string>();
    const size_t hash = reference.find('#');
    const std::string file = hash == 0 ? base : reference.substr(0, hash);
    const Schema whole = Schema::parse(schema_text(file));
    const std::string inside = hash == std::string::npos ? "" : reference.substr(hash + 1);
    return pattern_at(whole.at(Schema::json_pointer(inside)), file, place, step, depth + 1);
  }
  if (step == place.size() && schema.contains("pattern")) return schema.at("pattern").get<std::string>();
  std::vector<const Schema*> further;
  for (const char* several : {"anyOf", "oneOf", "allOf"}) {
    if (!schema.contains(several)) continue;
    for (const Schema& one : schema.at(several)) {
      const std::string found = pattern_at(one, base, place, step, depth + 1);
      if (!found.empty()) return found;
    }
  }
  if (step == place.size()) return "";
  if (schema.contains("properties") && schema.at("properties").contains(place[step])) {
    further.push_back(&schema.at("properties").at(place[step]));
  } else {
    for (const char* inside : {"items", "additionalProperties"}) {
      if (schema.contains(inside)) further.push_back(&schema.at(inside));
    }
  }
  for (const Schema* one : further) {
    const std::string found = pattern_at(*one, base, place, step + 1, depth + 1);
    if (!found.empty()) return found;
  }
  return "";
}

std::string words_of_pattern(const std::string& pattern) {
  static const std::map<std::string, std::string> kWords = {
      {"^[0-9a-f]{64}$", "64 hexadecimal digits"},
      {"^[a-z0-9-]+$", "an identifier of lower-case letters, digits and dashes"},
      {"^[a-z0-9_-]+$", "an identifier of lower-case letters, digits, dashes and underscores"},
      {"^[a-z0-9-]+/[a-z0-9-]+$", "a row, object/part, of lower-case letters, digits and dashes"},
      {"^[A-Za-z0-9_./-]+$", "letters, digits, dots, dashes, underscores and slashes"}};
  const auto words = kWords.find(pattern);
  if (words != kWords.end()) return words->second;
  return pattern.empty() ? "a text of another form" : "a text of the form " + pattern;
}

// The library's sentences are about its own words; ours say what is expected.
std::string plain_description(const std::string& description, const std::string& record,
                              const std::vector<std::string>& place) {
  static const std::string kUnknown = "Object contains a property that could not be validated using 'properties'";
  const size_t name = description.find(": '");
  if (description.compare(0, kUnknown.size(), kUnknown) == 0 && name != std::string::npos)
    return "unknown field " + description.substr(name + 2, description.size() - name - 3);
  if (description.find("Failed to match regex") == 0)
    return words_of_pattern(pattern_at(schema_document(record), record + ".json", place, 0));
  if (description.find("Value type not permitted") == 0) return "a value of another type";
  return description;
}

}  // namespace

std::vector<SchemaViolation> find_schema_violations(const nlohmann::ordered_json& document, const std::string& record) {
  const json plain = document;
  valijson::Validator validator;
  valijson::ValidationResults results;
  std::vector<SchemaViolation> violations;
  if (validator.validate(compiled_schema(record), valijson::adapters::NlohmannJsonAdapter(plain), &results)) {
    return violations;
  }
  valijson::ValidationResults::Error error;
  while (results.popError(error)) {
    const std::vector<std::string> place = steps_of(error.context);
    violations.push_back({pointer_of(place), plain_description(error.description, record, place),
                          static_cast<int>(error.context.size())});
  }
  if (violations.empty()) violations.push_back({"", "the schema does not accept it", 0});
  return violations;
}

const nlohmann::ordered_json& schema_document(const std::string& record) {
  thread_local std::map<std::string, nlohmann::ordered_json> cache;
  nlohmann::ordered_json& schema = cache[record];
  if (schema.is_null()) schema = nlohmann::ordered_json::parse(schema_text(record + ".json"));
  return schema;
}

}  // namespace physmas
