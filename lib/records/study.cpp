#include "records/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "records/json.h"

namespace physmas {

StudyKey load_study_key(const std::string& path) {
  const Json document = load_record(path, "study");
  StudyKey key;
  key.study = document.at("study").get<std::string>();
  key.token = document.at("token").get<std::string>();
  key.methods = document.at("methods").get<std::vector<std::string>>();
  for (const Json& json : document.at("cases")) {
    StudyKey::Case c;
    c.id = json.at("id").get<std::string>();
    c.multi_object = json.at("kind") == "multi-object";
    c.profiles = json.at("profiles").get<std::vector<std::string>>();
    for (const auto& [code, method] : json.at("codes").items()) c.codes[code] = method.get<std::string>();
    std::set<std::string> methods;
    for (const auto& [code, method] : c.codes) methods.insert(method);
    if (methods != std::set<std::string>(key.methods.begin(), key.methods.end()) || methods.size() != c.codes.size())
      throw invalid_field(path, fmt::format("/cases/{}/codes", key.cases.size()), json.at("codes"),
                          "one code for every method");
    key.cases.push_back(c);
  }
  return key;
}

void save_study_key(const std::string& path, const StudyKey& key, const Provenance& provenance) {
  Json json;
  json["study"] = key.study;
  json["token"] = key.token;
  json["methods"] = key.methods;
  json["cases"] = Json::array();
  for (const StudyKey::Case& c : key.cases) {
    json["cases"].push_back({{"id", c.id},
                             {"kind", c.multi_object ? "multi-object" : "multi-part"},
                             {"profiles", c.profiles},
                             {"codes", c.codes}});
  }
  save_record(path, "study", provenance, json);
}

StudyAnswers load_study_answers(const std::string& path, const StudyKey& key) {
  const Json document = load_record(path, "answers");
  if (document.at("token") != key.token)
    throw invalid_field(path, "/token", document.at("token"), "\"" + key.token + "\"",
                        "these answers belong to another study");
  StudyAnswers answers;
  answers.respondent = document.at("respondent").get<std::string>();
  std::set<std::string> answered;
  for (const Json& json : document.at("answers")) {
    const std::string pointer = fmt::format("/answers/{}", answers.answers.size());
    const std::string id = json.at("case").get<std::string>(), choice = json.at("choice").get<std::string>();
    const auto c = std::find_if(key.cases.begin(), key.cases.end(), [&](const auto& k) { return k.id == id; });
    if (c == key.cases.end()) throw invalid_field(path, pointer + "/case", json.at("case"), "a case of the study");
    if (!answered.insert(id).second)
      throw invalid_field(path, pointer + "/case", json.at("case"), "every case answered once");
    const auto order = json.at("order").get<std::vector<std::string>>();
    const std::set<std::string> shown(order.begin(), order.end());
    if (order.size() != c->codes.size() || shown.size() != order.size() ||
        !std::all_of(order.begin(), order.end(), [&](const std::string& code) { return c->codes.count(code) > 0; }))
      throw invalid_field(path, pointer + "/order", json.at("order"), "every code of the case once");
    if (shown.count(choice) == 0)
      throw invalid_field(path, pointer + "/choice", json.at("choice"), "one of the codes that were shown");
    answers.answers.push_back({id, c->codes.at(choice)});
  }
  return answers;
}

UprRecord load_upr(const std::string& path) {
  const Json document = load_record(path, "upr");
  UprRecord record;
  record.study = document.at("study").get<std::string>();
  record.methods = document.at("methods").get<std::vector<std::string>>();
  record.respondents = document.at("respondents").get<long>();
  record.resamples = document.at("resamples").get<long>();
  record.seed = document.at("seed").get<long>();
  for (const Json& json : document.at("cases")) {
    UprRecord::Case c;
    c.id = json.at("id").get<std::string>();
    c.responses = json.at("responses").get<long>();
    long counted = 0;
    for (const auto& [method, count] : json.at("counts").items()) counted += c.counts[method] = count.get<long>();
    if (counted != c.responses)
      throw invalid_field(path, fmt::format("/cases/{}/responses", record.cases.size()), json.at("responses"),
                          fmt::format("{}, the sum of the counts", counted));
    record.cases.push_back(c);
  }
  for (const Json& json : document.at("sets")) {
    UprRecord::Set set;
    set.name = json.at("name").get<std::string>();
    set.cases = json.at("cases").get<long>();
    for (const auto& [method, p] : json.at("upr").items())
      set.upr[method] = {p.at("value").get<double>(), p.at("low").get<double>(), p.at("high").get<double>()};
    record.sets.push_back(set);
  }
  return record;
}

void save_upr(const std::string& path, const UprRecord& record, const Provenance& provenance) {
  Json json;
  json["study"] = record.study;
  json["methods"] = record.methods;
  json["respondents"] = record.respondents;
  json["resamples"] = record.resamples;
  json["seed"] = record.seed;
  json["cases"] = Json::array();
  for (const UprRecord::Case& c : record.cases)
    json["cases"].push_back({{"id", c.id}, {"responses", c.responses}, {"counts", c.counts}});
  json["sets"] = Json::array();
  for (const UprRecord::Set& set : record.sets) {
    Json upr = Json::object();
    for (const auto& [method, p] : set.upr) upr[method] = {{"value", p.value}, {"low", p.low}, {"high", p.high}};
    json["sets"].push_back({{"name", set.name}, {"cases", set.cases}, {"upr", upr}});
  }
  save_record(path, "upr", provenance, json);
}

}  // namespace physmas
