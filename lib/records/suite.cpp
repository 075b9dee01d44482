#include "records/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "base/file.h"
#include "base/hash.h"
#include "records/json.h"
#include "records/labels.h"

namespace physmas {
namespace {

namespace fs = std::filesystem;

constexpr size_t kHashDigits = 64;

std::string hash_file(const Suite& suite) {
  return fs::path(suite.path).replace_extension(".sha256").string();
}

class Loader {
 public:
  explicit Loader(const std::string& path) : path_(path), document_(load_record(path, "suite")) {}

  Suite load() {
    suite_.path = path_;
    suite_.settings = document_.at("settings").get<std::vector<std::string>>();
    suite_.required = document_.at("required").get<std::vector<std::string>>();
    load_methods();
    suite_.hashes[fs::path(path_).filename().string()] = sha256_file(path_);
    for (size_t i = 0; i < document_.at("cases").size(); ++i) load_case(i);
    return suite_;
  }

 private:
  void load_methods() {
    std::set<std::string> ids;
    for (const Json& json : document_.at("methods")) {
      suite_.methods.push_back({json.at("id").get<std::string>(), json.at("name").get<std::string>(),
                                json.at("settings").get<std::vector<std::string>>(), json.value("candidate", "")});
      if (!ids.insert(suite_.methods.back().id).second)
        throw invalid_field(path_, fmt::format("/methods/{}/id", suite_.methods.size() - 1), json.at("id"),
                            "an id that no other method has");
    }
    suite_.comparison = document_.at("comparison").get<std::vector<std::string>>();
    for (size_t i = 0; i < suite_.comparison.size(); ++i) {
      if (ids.count(suite_.comparison[i]) == 0)
        throw invalid_field(path_, fmt::format("/comparison/{}", i), Json(suite_.comparison[i]), "the id of a method");
    }
  }

  void load_case(size_t index) {
    const Json& json = document_.at("cases")[index];
    const std::string pointer = fmt::format("/cases/{}", index);
    SuiteCase c;
    c.id = json.at("id").get<std::string>();
    if (!case_ids_.insert(c.id).second) throw invalid_field(path_, pointer + "/id", json.at("id"), "each id once");
    c.multi_object = json.at("kind") == "multi-object";
    c.objects = json.at("objects").get<std::vector<std::string>>();
    if (!c.multi_object && c.objects.size() != 1)
      throw invalid_field(path_, pointer + "/objects", json.at("objects"), "one object in a multi-part case");
    c.example = hashed_file(json, "example", pointer);
    c.reference = hashed_file(json, "reference", pointer);
    const Json example = load_record(c.example, "example");
    const Json reference = load_record(c.reference, "configuration");
    c.prompt = example.at("prompt").get<std::string>();
    check_objects(example, c, pointer);
    check_rows(example, reference, c);
    if (reference.contains("settings")) c.reference_settings = reference.at("settings").get<std::vector<std::string>>();
    c.key = sha256_text(sha256_file(c.example) + sha256_file(c.reference) + document_.at("settings").dump() +
                        PHYSMAS_VERSION)
                .substr(0, 16);
    suite_.cases.push_back(std::move(c));
  }

  std::string hashed_file(const Json& json, const char* field, const std::string& pointer) {
    const std::string name = json.at(field).get<std::string>();
    const std::string file = resolve_inside(folder_of(path_), name, path_, pointer + "/" + field);
    suite_.hashes[name] = sha256_file(file);
    return file;
  }

  void check_objects(const Json& example, const SuiteCase& c, const std::string& pointer) const {
    for (const std::string& object : c.objects) {
      const Json& all = example.at("objects");
      if (std::none_of(all.begin(), all.end(), [&](const Json& o) { return o.at("id") == object; }))
        throw invalid_field(path_, pointer + "/objects", Json(object), "an object of " + c.example);
    }
  }

  // The rows of the reference are those of the example; their branches are the case's profiles.
  static void check_rows(const Json& example, const Json& reference, SuiteCase& c) {
    const Json& rows = reference.at("rows");
    std::set<std::string> keys;
    for (const Json& object : example.at("objects")) {
      for (const Json& part : object.at("parts"))
        keys.insert(object.at("id").get<std::string>() + "/" + part.at("part").get<std::string>());
    }
    for (const std::string& key : keys) {
      if (!rows.contains(key))
        throw invalid_input({c.reference, "/rows", "no row \"" + key + "\"", "every row of " + c.example});
    }
    for (const auto& [key, row] : rows.items()) {
      if (keys.count(key) == 0) throw invalid_field(c.reference, "/rows/" + key, Json(key), "a row of " + c.example);
    }
    for (const char* branch : kBranchNames) {
      for (const auto& [key, row] : rows.items()) {
        if (row.at("branch") != branch) continue;
        c.profiles.push_back(branch);
        break;
      }
    }
  }

  std::string path_;
  Json document_;
  Suite suite_;
  std::set<std::string> case_ids_;
};

}  // namespace

Suite load_suite(const std::string& path) {
  return Loader(path).load();
}

void require_registered(const Suite& suite) {
  const std::string fix = "if the change is meant, register it: make evaluate-register";
  const std::string register_path = hash_file(suite);
  std::map<std::string, std::string> registered;
  std::istringstream lines(read_file(register_path));
  for (std::string line; std::getline(lines, line);) {
    if (line.size() > kHashDigits + 2) registered[line.substr(kHashDigits + 2)] = line.substr(0, kHashDigits);
  }
  for (const auto& [name, hash] : suite.hashes) {
    const std::string file = join_path(folder_of(suite.path), name);
    const auto found = registered.find(name);
    if (found == registered.end())
      throw invalid_input({file, "", "no hash of it in " + register_path, "a registered file", fix});
    if (found->second != hash)
      throw invalid_input({file, "", "SHA-256 " + hash, found->second + " as registered in " + register_path, fix});
  }
}

void register_suite(const Suite& suite) {
  std::string lines;
  for (const auto& [name, hash] : suite.hashes) lines += hash + "  " + name + "\n";
  write_file(hash_file(suite), lines);
}

}  // namespace physmas
