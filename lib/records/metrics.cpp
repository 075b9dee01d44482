#include "records/metrics.h"

#include "records/json.h"

namespace physmas {

void save_metrics(const std::string& path, const std::string& target, const std::vector<MetricEntry>& metrics,
                  const Provenance& provenance, const std::vector<ExchangeReference>& exchanges) {
  Json json;
  json["target"] = target;
  json["metrics"] = Json::object();
  for (const MetricEntry& metric : metrics) {
    Json entry;
    entry["status"] = metric.valid ? "valid" : "invalid";
    if (metric.valid) {
      entry["value"] = metric.value;
      entry["samples"] = metric.samples;
    } else {
      entry["reason"] = metric.reason;
    }
    json["metrics"][metric.name] = entry;
  }
  if (!exchanges.empty()) json["exchanges"] = to_json(exchanges);
  save_record(path, "metrics", provenance, json);
}

MetricsRecord load_metrics(const std::string& path) {
  const Json document = load_record(path, "metrics");
  MetricsRecord record;
  record.target = document.value("target", "scene");
  for (const auto& [name, json] : document.at("metrics").items()) {
    MetricEntry entry;
    entry.name = name;
    entry.valid = json.at("status") == "valid";
    entry.value = json.value("value", 0.0);
    entry.samples = json.value("samples", 0L);
    entry.reason = json.value("reason", "");
    record.metrics.push_back(entry);
  }
  return record;
}

}  // namespace physmas
