#include "records/material_records.h"

#include <algorithm>
#include <set>

#include "records/json.h"

namespace physmas {
namespace {

std::optional<double> optional_number(const Json& json, const char* key) {
  if (!json.contains(key) || json.at(key).is_null()) return std::nullopt;
  return json.at(key).get<double>();
}

LabelScores scores_from(const Json& json, const std::string& file, const std::string& pointer) {
  LabelScores scores;
  std::set<int> seen;
  for (const auto& [name, score] : json.items()) {
    const auto label = find_label(name);
    if (!label) throw invalid_field(file, pointer + "/" + name, name, "one of the fourteen visual labels");
    if (!seen.insert(*label).second) throw invalid_field(file, pointer + "/" + name, name, "each label once");
    scores.emplace_back(*label, score.get<double>());
  }
  return scores;
}

std::vector<CropRecord> crops_from(const Json& json, const std::string& file, const std::string& pointer) {
  std::vector<CropRecord> crops;
  for (const Json& entry : json.value("crops", Json::array())) {
    CropRecord crop;
    crop.valid = entry.value("valid", true);
    crop.E_mean = optional_number(entry, "E_mean");
    crop.E = optional_number(entry, "E");
    crop.E_uncertainty = optional_number(entry, "E_uncertainty");
    crop.nu_mean = optional_number(entry, "nu_mean");
    crop.nu = optional_number(entry, "nu");
    crop.nu_uncertainty = optional_number(entry, "nu_uncertainty");
    crop.evidence = scores_from(entry.value("evidence", Json::object()), file,
                                pointer + "/crops/" + std::to_string(crops.size()) + "/evidence");
    crops.push_back(std::move(crop));
  }
  return crops;
}

std::vector<VlmRecord> vlm_from(const Json& json, const std::string& file, const std::string& pointer) {
  std::vector<VlmRecord> records;
  for (const Json& entry : json.value("vlm", Json::array())) {
    VlmRecord record;
    record.success = entry.at("status") == "success";
    record.abstain = entry.value("abstain", false);
    record.confidence = optional_number(entry, "confidence");
    record.views = entry.at("views").get<std::vector<std::string>>();
    record.probabilities = scores_from(entry.at("probabilities"), file,
                                       pointer + "/vlm/" + std::to_string(records.size()) + "/probabilities");
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace

bool MaterialRecords::has_observations() const {
  return whole_object || std::any_of(rows.begin(), rows.end(),
                                     [](const RowObservations& row) { return !row.crops.empty() || !row.vlm.empty(); });
}

MaterialRecords load_material_records(const std::string& path, const Inventory& inventory) {
  const Json document = load_record(path, "material_records");
  MaterialRecords records;
  records.rows.resize(inventory.rows.size());
  std::set<int> seen;
  for (size_t i = 0; i < document.at("rows").size(); ++i) {
    const std::string pointer = "/rows/" + std::to_string(i);
    const Json& json = document.at("rows")[i];
    const int row = inventory.find_row(json.at("key").get<std::string>());
    if (row < 0) throw invalid_field(path, pointer + "/key", json.at("key"), "the key of a row of the inventory");
    if (!seen.insert(row).second) throw invalid_field(path, pointer + "/key", json.at("key"), "each row once");
    records.rows[row] = {crops_from(json, path, pointer), vlm_from(json, path, pointer), stated_from(json)};
  }
  if (document.contains("whole_object")) {
    const Json& json = document.at("whole_object");
    WholeObjectObservations whole;
    if (json.contains("label")) whole.label = find_label(json.at("label").get<std::string>()).value();
    whole.crops = crops_from(json, path, "/whole_object");
    records.whole_object = std::move(whole);
  }
  return records;
}

Json to_json(const std::vector<CropRecord>& crops) {
  Json json = Json::array();
  for (const CropRecord& crop : crops) {
    Json entry = Json::object();
    if (!crop.valid) entry["valid"] = false;
    const auto add = [&](const char* key, const std::optional<double>& value) {
      if (value) entry[key] = *value;
    };
    add("E_mean", crop.E_mean);
    add("E", crop.E);
    add("E_uncertainty", crop.E_uncertainty);
    add("nu_mean", crop.nu_mean);
    add("nu", crop.nu);
    add("nu_uncertainty", crop.nu_uncertainty);
    if (!crop.evidence.empty()) entry["evidence"] = scores_json(crop.evidence);
    json.push_back(entry);
  }
  return json;
}

Json to_json(const std::vector<VlmRecord>& answers) {
  Json json = Json::array();
  for (const VlmRecord& answer : answers) {
    json.push_back({{"status", answer.success ? "success" : "failed"},
                    {"abstain", answer.abstain},
                    {"confidence", answer.confidence ? Json(*answer.confidence) : Json()},
                    {"views", answer.views},
                    {"probabilities", scores_json(answer.probabilities)}});
  }
  return json;
}

void share_with_only_row(MaterialRecords& records, const Inventory& inventory) {
  int only = -1;
  for (size_t r = 0; r < inventory.rows.size(); ++r) {
    if (!records.rows[r].crops.empty() || !records.rows[r].vlm.empty()) return;
    if (inventory.rows[r].residual) continue;
    if (only >= 0) return;
    only = static_cast<int>(r);
  }
  if (only >= 0 && records.whole_object) records.rows[only].crops = records.whole_object->crops;
}

void append_records(MaterialRecords& records, const MaterialRecords& more) {
  records.rows.resize(std::max(records.rows.size(), more.rows.size()));
  for (size_t r = 0; r < more.rows.size(); ++r) {
    RowObservations& row = records.rows[r];
    row.crops.insert(row.crops.end(), more.rows[r].crops.begin(), more.rows[r].crops.end());
    row.vlm.insert(row.vlm.end(), more.rows[r].vlm.begin(), more.rows[r].vlm.end());
    if (row.stated.empty()) row.stated = more.rows[r].stated;
  }
  if (!records.whole_object) records.whole_object = more.whole_object;
}

}  // namespace physmas
