#include "records/candidate.h"

#include <set>

#include "records/inventory.h"
#include "records/json.h"

namespace physmas {

Candidate load_candidate(const std::string& path) {
  const Json document = load_record(path, "candidate");
  Candidate candidate;
  candidate.id = document.at("id").get<std::string>();
  candidate.transform = document.at("transform").get<std::string>();
  if (!document.at("parent").is_null()) candidate.parent = document.at("parent").get<std::string>();
  candidate.order = document.at("order").get<int>();
  candidate.round = document.at("round").get<int>();
  candidate.base_confidence = document.at("base_confidence").get<double>();
  std::set<int> indices;
  for (const Json& json : document.at("rows")) {
    const std::string pointer = "/rows/" + std::to_string(candidate.rows.size());
    CandidateRow row;
    row.key = json.at("key").get<std::string>();
    row.row = json.at("row").get<int>();
    row.branch = find_branch(json.at("branch").get<std::string>()).value();
    row.E = json.at("E").get<double>();
    row.nu = json.at("nu").get<double>();
    row.rho = json.at("rho").get<double>();
    row.label = find_label(json.at("label").get<std::string>()).value();
    row.residual = json.at("residual").get<bool>();
    if (json.contains("field")) {
      const Json& field = json.at("field");
      row.field = {{field.at("E").get<double>(), field.at("nu").get<double>(), field.at("rho").get<double>()},
                   find_label(field.at("label").get<std::string>()).value()};
    }
    if (!indices.insert(row.row).second) throw invalid_field(path, pointer + "/row", row.row, "each row once");
    candidate.rows.push_back(row);
  }
  const auto known = [&](const std::string& key) {
    for (const CandidateRow& row : candidate.rows) {
      if (row.key == key) return true;
    }
    return false;
  };
  for (const auto& [key, eta] : document.at("controls").at("projection").items()) {
    if (!known(key))
      throw invalid_field(path, "/controls/projection/" + key, eta, "the key of a row of this candidate");
    candidate.projection.emplace_back(key, eta.get<double>());
  }
  for (const Json& key : document.at("controls").at("retention")) {
    if (!known(key.get<std::string>()))
      throw invalid_field(path, "/controls/retention", key, "the key of a row of this candidate");
    candidate.retention.push_back(key.get<std::string>());
  }
  const Json& schedule = document.at("schedule");
  for (size_t i = 0; i < schedule.size(); ++i) {
    const std::string pointer = "/schedule/" + std::to_string(i);
    ScheduleOperation op = operation_from(schedule[i], path, pointer);
    for (const std::vector<int>* list : {&op.rows, &op.neighbours}) {
      for (int r : *list) {
        if (indices.count(r) == 0) throw invalid_field(path, pointer + "/rows", r, "row indices of this candidate");
      }
    }
    candidate.schedule.push_back(std::move(op));
  }
  const Json& t = document.at("timestep");
  candidate.timestep = {t.at("c_max").get<double>(), t.at("c_ref").get<double>(), t.at("target").get<double>(),
                        t.at("substeps").get<int>(), t.at("dt").get<double>(),    t.at("capped_by").get<std::string>()};
  candidate.omitted = omissions_from(document);
  return candidate;
}

void save_candidate(const std::string& path, const Candidate& candidate, const Provenance& provenance) {
  Json json;
  json["id"] = candidate.id;
  json["transform"] = candidate.transform;
  json["parent"] = candidate.parent.empty() ? Json() : Json(candidate.parent);
  json["order"] = candidate.order;
  json["round"] = candidate.round;
  json["base_confidence"] = candidate.base_confidence;
  json["rows"] = Json::array();
  for (const CandidateRow& row : candidate.rows) {
    json["rows"].push_back({{"key", row.key},
                            {"row", row.row},
                            {"branch", branch_name(row.branch)},
                            {"E", row.E},
                            {"nu", row.nu},
                            {"rho", row.rho},
                            {"label", kLabels[row.label].name},
                            {"residual", row.residual}});
    if (!row.field) continue;
    const ParticleNumbers& numbers = row.field->numbers;
    json["rows"].back()["field"] = {
        {"E", numbers.E}, {"nu", numbers.nu}, {"rho", numbers.rho}, {"label", kLabels[row.field->label].name}};
  }
  json["controls"]["projection"] = Json::object();
  for (const auto& [key, eta] : candidate.projection) json["controls"]["projection"][key] = eta;
  json["controls"]["retention"] = candidate.retention;
  json["schedule"] = Json::array();
  for (const ScheduleOperation& op : candidate.schedule) json["schedule"].push_back(to_json(op));
  const TimestepResult& t = candidate.timestep;
  json["timestep"] = {{"rule", "paper"},        {"c_max", t.c_max}, {"c_ref", t.c_ref},        {"target", t.target},
                      {"substeps", t.substeps}, {"dt", t.dt},       {"capped_by", t.capped_by}};
  json["omitted"] = to_json(candidate.omitted);
  save_record(path, "candidate", provenance, json);
}

Candidate load_candidate(const std::string& path, const std::string& id, const Inventory& inventory) {
  Candidate candidate = load_candidate(path);
  if (candidate.id != id) throw invalid_field(path, "/id", candidate.id, "\"" + id + "\"");
  for (size_t i = 0; i < candidate.rows.size(); ++i) {
    const CandidateRow& row = candidate.rows[i];
    if (row.row >= static_cast<int>(inventory.rows.size()) || inventory.rows[row.row].key() != row.key)
      throw invalid_field(path, "/rows/" + std::to_string(i) + "/key", row.key, "the inventory's key of this row");
  }
  return candidate;
}

CandidateRound load_round(const std::string& path) {
  const Json document = load_record(path, "round");
  CandidateRound round;
  round.round = document.at("round").get<int>();
  round.ids = document.at("candidates").get<std::vector<std::string>>();
  if (std::set<std::string>(round.ids.begin(), round.ids.end()).size() != round.ids.size()) {
    throw invalid_field(path, "/candidates", document.at("candidates"), "each id once");
  }
  round.omitted = omissions_from(document);
  return round;
}

void save_round(const std::string& path, const CandidateRound& round, const Provenance& provenance) {
  Json json;
  json["round"] = round.round;
  json["candidates"] = round.ids;
  json["omitted"] = to_json(round.omitted);
  save_record(path, "round", provenance, json);
}

}  // namespace physmas
