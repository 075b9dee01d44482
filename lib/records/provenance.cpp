#include "records/provenance.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/file.h"
#include "base/hash.h"
#include "records/hdf5_file.h"
#include "records/json.h"

namespace physmas {

namespace {

namespace fs = std::filesystem;

Provenance::Input named(const std::string& path) {
  Provenance::Input input;
  input.path = path;
  input.sha256 = sha256_of_record(path, &input.without_runtime);
  return input;
}

std::vector<Provenance::Input> files_in(const Json& provenance, const char* field) {
  std::vector<Provenance::Input> files;
  if (!provenance.is_object() || !provenance.contains(field)) return files;
  // The record's schema says the same; not every reader of a record asks it first.
  const auto is_text = [](const Json& file, const char* key) { return file.contains(key) && file.at(key).is_string(); };
  for (const Json& file : provenance.at(field)) {
    if (!file.is_object() || !is_text(file, "path") || !is_text(file, "sha256")) continue;
    files.push_back({file.at("path").get<std::string>(), file.at("sha256").get<std::string>(),
                     file.contains("without") && file.at("without") == "runtime"});
  }
  return files;
}

Error other_bytes(const std::string& record_path, const char* field, size_t i, const Provenance::Input& file,
                  const std::string& verb, const std::string& actual, const std::string& path, const std::string& fix) {
  return invalid_input(
      {record_path, fmt::format("/provenance/{}/{}", field, i),
       fmt::format("{} a {} with SHA-256 {}", verb, fs::path(file.path).filename().string(), file.sha256),
       actual + ", that of " + path, fix});
}

}  // namespace

void Provenance::add_input(const std::string& path) {
  inputs.push_back(named(path));
}

void Provenance::add_output(const std::string& path) {
  outputs.push_back(named(path));
}

std::string Provenance::sha256_of(const std::string& path) const {
  for (const Input& input : inputs) {
    if (input.path == path) return input.sha256;
  }
  return "";
}

std::string sha256_of_record(const std::string& path, bool* has_runtime) {
  if (has_runtime != nullptr) *has_runtime = false;
  if (fs::path(path).extension() == ".html") {
    std::string text = read_file(path);
    for (size_t start; (start = text.find(kPageRuntime[0])) != std::string::npos;) {
      const size_t end = text.find(kPageRuntime[1], start);
      if (end == std::string::npos) break;
      text.erase(start, end + kPageRuntime[1].size() - start);
      if (has_runtime != nullptr) *has_runtime = true;
    }
    return sha256_text(text);
  }
  if (fs::path(path).extension() == ".json") {
    const std::string text = read_file(path);
    // Most have none, and are not parsed for that.
    if (text.find("\"runtime\"") != std::string::npos) {
      Json document = parse_json(text, path);
      if (document.is_object() && document.erase("runtime") > 0) {
        if (has_runtime != nullptr) *has_runtime = true;
        return sha256_text(record_text(document));
      }
    }
    return sha256_text(text);
  }
  return sha256_file(path);
}

RecordedFiles recorded_files(const std::string& path, const std::string& hdf5_record) {
  Json provenance;
  if (fs::path(path).extension() == ".h5") {
    const Hdf5Reader file(path, hdf5_record);
    provenance = parse_json(file.read_text_attribute("/", "provenance"), path);
  } else {
    const Json document = parse_json(read_file(path), path);
    if (document.is_object() && document.contains("provenance")) provenance = document.at("provenance");
  }
  return {files_in(provenance, "inputs"), files_in(provenance, "outputs"),
          provenance.is_object() && provenance.contains("outputs")};
}

bool is_unchanged(const std::string& path, const Provenance::Input& named) {
  return (named.without_runtime ? sha256_of_record(path) : sha256_file(path)) == named.sha256;
}

void require_made_from(const std::string& record_path, const std::string& input_path, bool must_list,
                       const std::string& hdf5_record) {
  const std::vector<Provenance::Input> inputs = recorded_files(record_path, hdf5_record).inputs;
  const std::string whole = sha256_file(input_path);
  const bool is_record = fs::path(input_path).extension() == ".json";
  const std::string stable = is_record ? sha256_of_record(input_path) : whole;
  const auto actual = [&](const Provenance::Input& input) { return input.without_runtime ? stable : whole; };
  for (const Provenance::Input& input : inputs) {
    if (input.sha256 == actual(input)) return;
  }
  const fs::path name = fs::path(input_path).filename();
  for (size_t i = 0; i < inputs.size(); ++i) {
    if (fs::path(inputs[i].path).filename() != name) continue;
    throw other_bytes(record_path, "inputs", i, inputs[i], "made from", actual(inputs[i]), input_path,
                      "make the record again from this file");
  }
  if (must_list) {
    throw invalid_input({record_path, "/provenance/inputs",
                         std::to_string(inputs.size()) + " inputs without " + name.string(),
                         "an input with SHA-256 " + stable + ", that of " + input_path});
  }
}

void require_written_with(const std::string& record_path, const std::string& output_path) {
  const RecordedFiles files = recorded_files(record_path);
  if (!files.names_outputs) return;
  const fs::path name = fs::path(output_path).filename();
  for (size_t i = 0; i < files.outputs.size(); ++i) {
    if (fs::path(files.outputs[i].path).filename() != name) continue;
    if (is_unchanged(output_path, files.outputs[i])) return;
    throw other_bytes(record_path, "outputs", i, files.outputs[i], "written with", sha256_file(output_path),
                      output_path, "make both again");
  }
  throw invalid_input(
      {record_path, "/provenance/outputs", "no " + name.string(), "the hash of " + output_path, "make both again"});
}

void require_same_state(const std::string& record_path, const std::string& other_path) {
  const std::vector<Provenance::Input> inputs = recorded_files(record_path).inputs;
  const std::vector<Provenance::Input> others = recorded_files(other_path).inputs;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const fs::path name = fs::path(inputs[i].path).filename();
    if (name.extension() != ".h5") continue;
    for (const Provenance::Input& other : others) {
      if (fs::path(other.path).filename() != name || other.sha256 == inputs[i].sha256) continue;
      throw invalid_input({record_path, "/provenance/inputs/" + std::to_string(i) + "/sha256",
                           inputs[i].sha256 + " for " + name.string(), other.sha256 + ", as in " + other_path,
                           "make both from the same state"});
    }
  }
}

}  // namespace physmas
