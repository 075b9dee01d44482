#include "records/material_records.h"

#include <set>

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
    records.rows[row] = {crops_from(json, path, pointer), vlm_from(json, path, pointer)};
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

}  // namespace physmas
