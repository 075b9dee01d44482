#include "records/provenance.h"

#include <filesystem>

#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"

namespace physmas {

void Provenance::add_input(const std::string& path) {
  inputs.push_back({path, sha256_file(path)});
}

std::string Provenance::sha256_of(const std::string& path) const {
  for (const Input& input : inputs) {
    if (input.path == path) return input.sha256;
  }
  return "";
}

void require_made_from(const std::string& record_path, const std::string& input_path, bool must_list) {
  namespace fs = std::filesystem;
  const std::string actual = sha256_file(input_path);
  const Json document = parse_json(read_file(record_path), record_path);
  const Json inputs = document.value(Json::json_pointer("/provenance/inputs"), Json::array());
  for (const Json& input : inputs) {
    if (input.at("sha256") == actual) return;
  }
  const fs::path name = fs::path(input_path).filename();
  for (size_t i = 0; i < inputs.size(); ++i) {
    if (fs::path(inputs[i].at("path").get<std::string>()).filename() != name) continue;
    throw invalid_input({record_path, "/provenance/inputs/" + std::to_string(i),
                         "made from a " + name.string() + " with SHA-256 " + inputs[i].at("sha256").get<std::string>(),
                         actual + ", that of " + input_path, "make the record again from this file"});
  }
  if (must_list) {
    throw invalid_input({record_path, "/provenance/inputs",
                         std::to_string(inputs.size()) + " inputs without " + name.string(),
                         "an input with SHA-256 " + actual + ", that of " + input_path});
  }
}

void require_same_state(const std::string& record_path, const std::string& other_path) {
  namespace fs = std::filesystem;
  const auto inputs_of = [](const std::string& path) {
    return parse_json(read_file(path), path).value(Json::json_pointer("/provenance/inputs"), Json::array());
  };
  const Json inputs = inputs_of(record_path), others = inputs_of(other_path);
  for (size_t i = 0; i < inputs.size(); ++i) {
    const fs::path name = fs::path(inputs[i].at("path").get<std::string>()).filename();
    if (name.extension() != ".h5") continue;
    for (const Json& other : others) {
      if (fs::path(other.at("path").get<std::string>()).filename() != name ||
          other.at("sha256") == inputs[i].at("sha256"))
        continue;
      throw invalid_input({record_path, "/provenance/inputs/" + std::to_string(i) + "/sha256",
                           inputs[i].at("sha256").get<std::string>() + " for " + name.string(),
                           other.at("sha256").get<std::string>() + ", as in " + other_path,
                           "make both from the same state"});
    }
  }
}

}  // namespace physmas
