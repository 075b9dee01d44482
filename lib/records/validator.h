// JSON Schema validation. A thin wall around valijson, which is slow to compile.
#ifndef PHYSMAS_RECORDS_VALIDATOR_H
#define PHYSMAS_RECORDS_VALIDATOR_H

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace physmas {

struct SchemaViolation {
  std::string pointer;      // JSON pointer of the offending value
  std::string description;  // what the schema says
  int depth = 0;            // number of steps in the pointer
};

// Validates against the embedded schemas/<record>.json. Throws an internal Error when there is no such schema.
std::vector<SchemaViolation> find_schema_violations(const nlohmann::ordered_json& document, const std::string& record);

// The embedded schemas/<record>.json itself. Throws an internal Error when there is none.
const nlohmann::ordered_json& schema_document(const std::string& record);

}  // namespace physmas

#endif
