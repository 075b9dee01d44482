#include "records/screen.h"

#include "records/json.h"

namespace physmas {
namespace {

std::optional<double> number_or_none(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional<double>(json.get<double>());
}

Json number_or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace

ScreenRecord load_screen(const std::string& path) {
  const Json document = load_record(path, "screen");
  ScreenRecord record;
  record.round = document.at("round").get<int>();
  record.tau = document.at("tau").get<double>();
  record.weights = document.value("weights", Json::array()).get<std::vector<double>>();
  for (const Json& json : document.at("candidates")) {
    ScreenedCandidate c;
    c.id = json.at("id").get<std::string>();
    c.transform = json.at("transform").get<std::string>();
    c.order = json.at("order").get<int>();
    c.round = json.at("round").get<int>();
    const Json& f = json.at("features");
    c.video = f.at("video").get<double>();
    c.part_confidence = f.at("part_confidence").get<double>();
    c.diversity = f.at("diversity").get<double>();
    c.role = f.at("role").get<double>();
    c.base = f.at("base").get<double>();
    c.density = f.at("density").get<double>();
    c.solver = f.at("solver").get<double>();
    for (const Json& term : json.value("video_terms", Json::array())) {
      c.video_terms.emplace_back(term.at("term").get<std::string>(), term.at("value").get<double>());
    }
    c.penalty = json.at("penalty").get<double>();
    c.score = json.at("score").get<double>();
    c.achieved = number_or_none(json.value("achieved", Json()));
    c.stillness = number_or_none(json.value("stillness", Json()));
    for (const Json& gate : json.at("gates")) {
      c.gates.push_back({gate.at("name").get<std::string>(), gate.at("passed").get<bool>(), gate.at("measured"),
                         gate.at("limit"), gate.value("advice", "")});
    }
    c.valid = json.at("valid").get<bool>();
    c.admitted = json.at("admitted").get<bool>();
    c.rank = json.at("rank").get<int>();
    c.advice = json.value("advice", "");
    record.candidates.push_back(std::move(c));
  }
  record.decision = document.at("decision").get<std::string>();
  record.reason = document.value("reason", "");
  if (!document.at("accepted").is_null()) record.accepted = document.at("accepted").get<std::string>();
  if (!document.at("repair").is_null()) {
    record.repair_base = document.at("repair").at("base").get<std::string>();
    record.repair_routes = document.at("repair").at("routes").get<std::vector<std::string>>();
  }
  if (!document.at("audit").is_null()) {
    record.audited = true;
    record.audit_passed = document.at("audit").at("passed").get<bool>();
    for (const Json& check : document.at("audit").at("checks")) {
      record.audit.push_back({check.at("name").get<std::string>(), check.at("passed").get<bool>(), check.at("measured"),
                              check.at("expected")});
    }
  }
  record.omitted = omissions_from(document);
  return record;
}

void save_screen(const std::string& path, const ScreenRecord& record, const Provenance& provenance) {
  Json json;
  json["round"] = record.round;
  json["tau"] = record.tau;
  json["weights"] = record.weights;
  json["candidates"] = Json::array();
  for (const ScreenedCandidate& c : record.candidates) {
    Json entry;
    entry["id"] = c.id;
    entry["transform"] = c.transform;
    entry["order"] = c.order;
    entry["round"] = c.round;
    entry["features"] = {{"video", c.video},         {"part_confidence", c.part_confidence},
                         {"diversity", c.diversity}, {"role", c.role},
                         {"base", c.base},           {"density", c.density},
                         {"solver", c.solver}};
    entry["video_terms"] = Json::array();
    for (const auto& [term, value] : c.video_terms) entry["video_terms"].push_back({{"term", term}, {"value", value}});
    entry["penalty"] = c.penalty;
    entry["score"] = c.score;
    entry["achieved"] = number_or_null(c.achieved);
    entry["stillness"] = number_or_null(c.stillness);
    entry["gates"] = Json::array();
    for (const ScreenedCandidate::Gate& gate : c.gates) {
      entry["gates"].push_back(
          {{"name", gate.name}, {"passed", gate.passed}, {"measured", gate.measured}, {"limit", gate.limit}});
      if (!gate.advice.empty()) entry["gates"].back()["advice"] = gate.advice;
    }
    entry["valid"] = c.valid;
    entry["admitted"] = c.admitted;
    entry["rank"] = c.rank;
    if (!c.advice.empty()) entry["advice"] = c.advice;
    json["candidates"].push_back(entry);
  }
  json["decision"] = record.decision;
  json["reason"] = record.reason;
  json["accepted"] = record.accepted.empty() ? Json() : Json(record.accepted);
  json["repair"] =
      record.repair_base.empty() ? Json() : Json({{"base", record.repair_base}, {"routes", record.repair_routes}});
  if (record.audited) {
    json["audit"]["passed"] = record.audit_passed;
    json["audit"]["checks"] = Json::array();
    for (const AuditCheck& check : record.audit) {
      json["audit"]["checks"].push_back(
          {{"name", check.name}, {"passed", check.passed}, {"measured", check.measured}, {"expected", check.expected}});
    }
  } else {
    json["audit"] = Json();
  }
  json["omitted"] = to_json(record.omitted);
  save_record(path, "screen", provenance, json);
}

void save_accepted(const std::string& path, const AcceptedRecord& record, const Provenance& provenance) {
  Json json;
  json["candidate"] = record.candidate;
  json["round"] = record.round;
  json["score"] = record.score;
  json["video"] = record.video;
  json["frames"] = record.frames;
  json["audit"] = Json::object();
  for (const auto& [role, file] : record.audit) json["audit"][role] = file;
  save_record(path, "accepted", provenance, json);
}

AcceptedRecord load_accepted(const std::string& path) {
  const Json document = load_record(path, "accepted");
  AcceptedRecord record;
  record.candidate = document.at("candidate").get<std::string>();
  record.round = document.at("round").get<int>();
  record.score = document.at("score").get<double>();
  record.video = document.at("video").get<std::string>();
  record.frames = document.at("frames").get<int>();
  for (const auto& [role, file] : document.at("audit").items())
    record.audit.emplace_back(role, file.get<std::string>());
  return record;
}

}  // namespace physmas
