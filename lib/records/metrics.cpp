#include "records/metrics.h"

namespace physmas {

void save_metrics(const std::string& path, const std::string& target, const std::vector<MetricEntry>& metrics,
                  const Provenance& provenance) {
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
  save_record(path, "metrics", provenance, json);
}

}  // namespace physmas
