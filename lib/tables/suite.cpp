#include "tables/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "records/json.h"

namespace physmas::tables {
namespace {

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<const SuiteCase*> chosen_cases(const Suite& suite, const std::vector<std::string>& ids) {
  std::vector<const SuiteCase*> chosen;
  std::vector<std::string> known;
  for (const SuiteCase& c : suite.cases) {
    known.push_back(c.id);
    if (ids.empty() || std::find(ids.begin(), ids.end(), c.id) != ids.end()) chosen.push_back(&c);
  }
  for (const std::string& id : ids) {
    if (std::find(known.begin(), known.end(), id) == known.end())
      throw Error(ExitCode::usage,
                  fmt::format("--cases: found \"{}\", expected some of {}", one_line(id, 80), join(known)));
  }
  return chosen;
}

std::vector<std::string> fields_of(const std::string& path) {
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure)) return {};
  std::istringstream lines(read_file(path));
  std::string line, field;
  std::getline(lines, line);
  std::vector<std::string> fields;
  for (std::istringstream rest(line); std::getline(rest, field, '\t');) fields.push_back(field);
  return fields;
}

Json failure_json(const std::string& reason) {
  return {{"status", "failed"}, {"reason", one_line(reason.empty() ? "no reason given" : reason)}};
}

Json result_json(const std::string& evaluation, const SuiteCase& c, const SuiteMethod& method) {
  const std::string folder = c.id + "/" + method.id;
  const std::vector<std::string> fields = fields_of(evaluation + "/results/" + folder + "/result.tsv");
  if (fields.empty()) return failure_json("no result");
  if (fields[0] == "failed") return failure_json(fields.size() > 1 ? fields[1] : "");
  const double seconds = fields.size() == 3 ? std::strtod(fields[2].c_str(), nullptr) : 0;
  if (fields[0] != "done" || !(seconds > 0)) return failure_json("result.tsv is damaged");
  Json json = {{"status", "done"}, {"video", folder + "/videos/" + fields[1] + ".mp4"}};
  for (const std::string& object : c.objects)
    json["metrics"].push_back("results/" + folder + "/motion-" + object + ".json");
  json["seconds"] = seconds;
  return json;
}

}  // namespace

std::string suite_makefile(const Suite& suite, const std::vector<std::string>& ids) {
  std::string text, cases, methods;
  const auto set = [&](const std::string& name, const std::string& value) { text += name + " := " + value + "\n"; };
  set("SUITE_SETTINGS", join(suite.settings));
  for (const SuiteMethod& method : suite.methods) {
    methods += " " + method.id;
    set("SUITE_SETTINGS_" + method.id, join(method.settings));
    set("SUITE_CANDIDATE_" + method.id, method.candidate);
  }
  for (const SuiteCase* c : chosen_cases(suite, ids)) {
    cases += " " + c->id;
    set("SUITE_EXAMPLE_" + c->id, c->example);
    set("SUITE_REFERENCE_" + c->id, c->reference);
    set("SUITE_REFERENCE_SETTINGS_" + c->id, join(c->reference_settings));
    set("SUITE_OBJECTS_" + c->id, join(c->objects));
    set("SUITE_KEY_" + c->id, c->key);
  }
  return "SUITE_CASES :=" + cases + "\nSUITE_METHODS :=" + methods + "\n" + text;
}

Json collect_evaluation(const Suite& suite, const std::string& evaluation, const std::vector<std::string>& ids) {
  Json json;
  json["methods"] = Json::array();
  for (const SuiteMethod& method : suite.methods) json["methods"].push_back({{"id", method.id}, {"name", method.name}});
  json["comparison"] = suite.comparison;
  json["required"] = suite.required;
  json["cases"] = Json::array();
  for (const SuiteCase* c : chosen_cases(suite, ids)) {
    Json entry = {{"id", c->id}, {"kind", c->multi_object ? "multi-object" : "multi-part"}, {"prompt", c->prompt}};
    if (c->multi_object) {
      entry["objects"] = c->objects;
    } else {
      entry["profiles"] = c->profiles;
    }
    for (const SuiteMethod& method : suite.methods) entry["results"][method.id] = result_json(evaluation, *c, method);
    json["cases"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace physmas::tables
