#include "records/validator.h"

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
std::string pointer_of(const std::vector<std::string>& context) {
  std::string pointer;
  for (const std::string& step : context) {
    if (step == "<root>") continue;
    pointer += "/" + (step.size() > 2 && step.front() == '[' ? step.substr(1, step.size() - 2) : step);
  }
  return pointer;
}

// valijson's sentence for an unknown field is long and does not say "unknown".
std::string plain_description(const std::string& description) {
  static const std::string kUnknown = "Object contains a property that could not be validated using 'properties'";
  const size_t name = description.find(": '");
  if (description.compare(0, kUnknown.size(), kUnknown) != 0 || name == std::string::npos) return description;
  return "unknown field " + description.substr(name + 2, description.size() - name - 3);
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
    violations.push_back(
        {pointer_of(error.context), plain_description(error.description), static_cast<int>(error.context.size())});
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
