#include "records/evidence.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "records/json.h"

namespace physmas {
namespace {

int label_from(const Json& json) {
  return find_label(json.get<std::string>()).value();
}

LabelScores scores_from(const Json& json, const std::string& file, const std::string& pointer) {
  LabelScores scores;
  for (const auto& [name, score] : json.items()) {
    const auto label = find_label(name);
    if (!label) throw invalid_field(file, pointer + "/" + name, score, "one of the fourteen visual labels");
    scores.emplace_back(*label, score.get<double>());
  }
  return scores;
}

// What the schema cannot see: a posterior in stored order, and centres inside the selected label's domain.
void check_row(const EvidenceRow& row, const std::string& file, const std::string& pointer) {
  constexpr double kRounding = 1e-9;
  double sum = 0;
  for (size_t i = 0; i < row.posterior.size(); ++i) {
    sum += row.posterior[i].second;
    if (i > 0 && row.posterior[i].second > row.posterior[i - 1].second) {
      throw invalid_field(file, pointer + "/posterior/" + std::to_string(i) + "/probability", row.posterior[i].second,
                          "no more than the one before it: the posterior is stored in descending order");
    }
  }
  if (std::abs(sum - 1) > kRounding)
    throw invalid_field(file, pointer + "/posterior", sum, "probabilities that sum to 1");
  const LabelPrior& prior = kLabels[row.label];
  const double lo = std::log10(prior.E_lo), hi = std::log10(prior.E_hi);
  if (row.log10_E < lo - kRounding || row.log10_E > hi + kRounding) {
    throw invalid_field(file, pointer + "/E/log10", row.log10_E,
                        fmt::format("{} to {}, the domain of {}", lo, hi, prior.name));
  }
  if (row.nu < prior.nu_lo - kRounding || row.nu > prior.nu_hi + kRounding) {
    throw invalid_field(file, pointer + "/nu/value", row.nu,
                        fmt::format("{} to {}, the domain of {}", prior.nu_lo, prior.nu_hi, prior.name));
  }
}

EvidenceRow row_from(const Json& json, const std::string& file, const std::string& pointer) {
  EvidenceRow row;
  row.key = json.at("key").get<std::string>();
  row.residual = json.at("residual").get<bool>();
  row.gaussians = json.at("gaussians").get<long>();
  if (json.contains("observations")) row.observations = json.at("observations");
  row.stated = stated_from(json);
  for (const Json& label : json.value("expected_labels", Json::array()))
    row.expected_labels.push_back(label_from(label));
  for (const auto& [source, scores] : json.at("sources").items()) {
    row.sources.emplace_back(source, scores_from(scores, file, pointer + "/sources/" + source));
  }
  row.role_lookup = scores_from(json.value("role_lookup", Json::object()), file, pointer + "/role_lookup");
  row.scores = scores_from(json.at("scores"), file, pointer + "/scores");
  row.fallback = json.value("fallback", false);
  std::array<bool, kLabelCount> seen{};
  for (const Json& entry : json.at("posterior")) {
    const int label = label_from(entry.at("label"));
    if (seen[label]) throw invalid_field(file, pointer + "/posterior", entry, "each label once");
    seen[label] = true;
    row.posterior.emplace_back(label, entry.at("probability").get<double>());
  }
  for (const Json& entry : json.at("guards")) {
    row.guards.push_back({entry.at("name").get<std::string>(), entry.at("applied").get<bool>(),
                          label_from(entry.at("label")), entry.at("measured")});
  }
  row.label = label_from(json.at("label"));
  row.confidence = json.at("confidence").get<double>();
  const Json& E = json.at("E");
  row.log10_E = E.at("log10").get<double>();
  row.E_dispersion = E.at("dispersion").get<double>();
  row.E_records = E.at("records").get<int>();
  row.E_mean = E.value("mean", row.log10_E);
  row.E_spread = E.value("spread", 0.0);
  row.E_uncertainty = E.value("uncertainty", 0.0);
  const Json& nu = json.at("nu");
  row.nu = nu.at("value").get<double>();
  row.nu_dispersion = nu.at("dispersion").get<double>();
  row.nu_records = nu.at("records").get<int>();
  row.nu_mean = nu.value("mean", row.nu);
  row.nu_uncertainty = nu.value("uncertainty", 0.0);
  row.entropy = json.value("entropy", 0.0);
  row.mask_confidence = json.at("mask_confidence").get<double>();
  row.part_confidence = json.at("part_confidence").get<double>();
  if (json.contains("field")) {
    const Json& field = json.at("field");
    const auto range = [&](const char* name) {
      const Json& numbers = field.at(name);
      return EvidenceRow::Field::Range{numbers.at("least").get<double>(), numbers.at("median").get<double>(),
                                       numbers.at("most").get<double>(), numbers.at("clamped").get<long>()};
    };
    row.field = {field.at("particles").get<long>(), field.at("sampled").get<long>(), range("E"), range("nu"),
                 range("rho")};
  }
  check_row(row, file, pointer);
  return row;
}

Json row_json(const EvidenceRow& row) {
  Json json;
  json["key"] = row.key;
  json["residual"] = row.residual;
  json["gaussians"] = row.gaussians;
  if (!row.observations.is_null()) json["observations"] = row.observations;
  if (!row.stated.empty()) json["stated"] = to_json(row.stated);
  json["expected_labels"] = Json::array();
  for (int label : row.expected_labels) json["expected_labels"].push_back(kLabels[label].name);
  json["sources"] = Json::object();
  for (const auto& [source, scores] : row.sources) json["sources"][source] = scores_json(scores);
  json["role_lookup"] = scores_json(row.role_lookup);
  json["scores"] = scores_json(row.scores);
  json["fallback"] = row.fallback;
  json["posterior"] = Json::array();
  std::array<double, kBranchCount> profiles{};
  for (const auto& [label, probability] : row.posterior) {
    json["posterior"].push_back({{"label", kLabels[label].name}, {"probability", probability}});
    profiles[static_cast<int>(kLabels[label].branch)] += probability;
  }
  json["guards"] = Json::array();
  for (const EvidenceRow::Guard& guard : row.guards) {
    Json entry;
    entry["name"] = guard.name;
    entry["applied"] = guard.applied;
    entry["label"] = kLabels[guard.label].name;
    entry["measured"] = guard.measured;
    json["guards"].push_back(entry);
  }
  json["label"] = kLabels[row.label].name;
  json["confidence"] = row.confidence;
  // Rounding may lift a sum of probabilities a hair above one.
  for (int b = 0; b < kBranchCount; ++b) json["profiles"][kBranchNames[b]] = std::min(1.0, profiles[b]);
  json["E"] = {{"log10", row.log10_E}, {"dispersion", row.E_dispersion}, {"records", row.E_records},
               {"mean", row.E_mean},   {"spread", row.E_spread},         {"uncertainty", row.E_uncertainty}};
  json["nu"] = {{"value", row.nu},
                {"dispersion", row.nu_dispersion},
                {"records", row.nu_records},
                {"mean", row.nu_mean},
                {"uncertainty", row.nu_uncertainty}};
  json["entropy"] = row.entropy;
  json["mask_confidence"] = row.mask_confidence;
  json["part_confidence"] = row.part_confidence;
  if (row.field) {
    const auto range = [](const EvidenceRow::Field::Range& numbers) {
      return Json{
          {"least", numbers.least}, {"median", numbers.median}, {"most", numbers.most}, {"clamped", numbers.clamped}};
    };
    json["field"] = {{"particles", row.field->particles},
                     {"sampled", row.field->sampled},
                     {"E", range(row.field->E)},
                     {"nu", range(row.field->nu)},
                     {"rho", range(row.field->rho)}};
  }
  return json;
}

}  // namespace

Json scores_json(const LabelScores& scores) {
  Json json = Json::object();
  for (const auto& [label, score] : scores) json[kLabels[label].name] = score;
  return json;
}

StatedMaterial stated_from(const Json& row) {
  StatedMaterial stated;
  if (!row.contains("stated")) return stated;
  const Json& json = row.at("stated");
  const auto number = [&](const char* key) {
    return json.contains(key) ? std::optional<double>(json.at(key).get<double>()) : std::nullopt;
  };
  if (json.contains("label")) stated.label = label_from(json.at("label"));
  stated.E = number("E");
  stated.nu = number("nu");
  stated.rho = number("rho");
  return stated;
}

Json to_json(const StatedMaterial& stated) {
  Json json = Json::object();
  if (stated.label) json["label"] = kLabels[*stated.label].name;
  if (stated.E) json["E"] = *stated.E;
  if (stated.nu) json["nu"] = *stated.nu;
  if (stated.rho) json["rho"] = *stated.rho;
  return json;
}

double EvidenceRow::probability(int wanted) const {
  for (const auto& [candidate, p] : posterior) {
    if (candidate == wanted) return p;
  }
  return 0;
}

Evidence load_evidence(const std::string& path, const std::vector<std::string>& row_keys) {
  const Json document = load_record(path, "evidence");
  Evidence evidence;
  const Json& rows = document.at("rows");
  for (size_t r = 0; r < rows.size(); ++r) {
    const std::string pointer = "/rows/" + std::to_string(r);
    if (r >= row_keys.size() || rows[r].at("key") != row_keys[r]) {
      throw invalid_field(
          path, pointer + "/key", rows[r].at("key"),
          r < row_keys.size() ? "\"" + row_keys[r] + "\", as in the inventory" : "no more rows than the inventory has");
    }
    evidence.rows.push_back(row_from(rows[r], path, pointer));
  }
  if (rows.size() != row_keys.size())
    throw invalid_input({path, "/rows", std::to_string(rows.size()) + " rows",
                         std::to_string(row_keys.size()) + ", as in the inventory"});
  const Json& whole = document.at("whole_object");
  evidence.whole_object.source = whole.at("source").get<std::string>();
  if (whole.contains("label") && !whole.at("label").is_null())
    evidence.whole_object.label = label_from(whole.at("label"));
  evidence.whole_object.branch = find_branch(whole.at("branch").get<std::string>()).value();
  evidence.whole_object.E = whole.at("E").get<double>();
  evidence.whole_object.nu = whole.at("nu").get<double>();
  evidence.whole_object.rho = whole.at("rho").get<double>();
  if (whole.contains("crops")) evidence.whole_object.crops = whole.at("crops");
  evidence.exchanges = exchanges_from(document);
  evidence.omitted = omissions_from(document);
  return evidence;
}

void save_evidence(const std::string& path, const Evidence& evidence, const Provenance& provenance) {
  Json json;
  json["rows"] = Json::array();
  for (const EvidenceRow& row : evidence.rows) json["rows"].push_back(row_json(row));
  const WholeObject& whole = evidence.whole_object;
  json["whole_object"] = {{"source", whole.source},
                          {"label", whole.label < 0 ? Json() : Json(kLabels[whole.label].name)},
                          {"branch", branch_name(whole.branch)},
                          {"E", whole.E},
                          {"nu", whole.nu},
                          {"rho", whole.rho}};
  if (!whole.crops.is_null()) json["whole_object"]["crops"] = whole.crops;
  json["exchanges"] = to_json(evidence.exchanges);
  json["omitted"] = to_json(evidence.omitted);
  save_record(path, "evidence", provenance, json);
}

}  // namespace physmas
