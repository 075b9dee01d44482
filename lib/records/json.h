// The one JSON loader and writer: strict parsing, schema validation on read and on write, atomic and stable output.
#ifndef PHYSMAS_RECORDS_JSON_H
#define PHYSMAS_RECORDS_JSON_H

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

#include "records/json_fwd.h"
#include "records/provenance.h"

namespace physmas {

// Parses `text`, in time in proportion to its length. Refuses malformed JSON and numbers out of range (with line and
// column), duplicate keys, objects of more than 4096 keys, nesting deeper than 64, each with exit code 3. `file` is only
// named in messages.
Json parse_json(const std::string& text, const std::string& file);

// Reads the record `physmas/<record>/1` and validates it against schemas/<record>.json. Every violation is an Error
// (exit code 3) that names the file, the JSON pointer, what was found and what was expected.
Json load_record(const std::string& path, const std::string& record);

// Validates, as load_record does, a document that is already parsed.
void validate_record(const Json& document, const std::string& record, const std::string& file);

// Adds `schema` and `provenance` in front of `body`, validates the result, and writes it atomically with two-space
// indentation. An invalid document is a fault of ours (exit code 70).
void save_record(const std::string& path, const std::string& record, const Provenance& provenance, const Json& body);

// A whole document as it stands in a file.
std::string record_text(const Json& document);

// On one line; bytes that are no UTF-8, as a file's name may hold them, are replaced.
std::string compact_text(const Json& json);

// An Error for a field that the schema cannot judge (an id that does not resolve, say); shows the value found.
Error invalid_field(const std::string& file, const std::string& pointer, const Json& found, const std::string& expected,
                    const std::string& fix = "");

// Conversions that several records share. The JSON is already valid.
Json to_json(const Eigen::Vector3d& v);
Eigen::Vector3d vector3_from(const Json& json);
Json to_json(const Provenance& provenance, const std::string& folder);
Json to_json(const std::vector<Omission>& omitted);
std::vector<Omission> omissions_from(const Json& document);  // its `omitted` list, empty when absent
Json to_json(const std::vector<ExchangeReference>& exchanges);
std::vector<ExchangeReference> exchanges_from(const Json& document);  // its `exchanges` list, empty when absent

}  // namespace physmas

#endif
