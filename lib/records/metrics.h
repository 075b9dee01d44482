// metrics.json: measurements of a run; one that could not be made says why and has no value.
#ifndef PHYSMAS_RECORDS_METRICS_H
#define PHYSMAS_RECORDS_METRICS_H

#include <string>
#include <vector>

#include "records/provenance.h"

namespace physmas {

struct MetricEntry {
  std::string name;
  bool valid = false;
  double value = 0;
  long samples = 0;
  std::string reason;
};

// exchanges: with the model servers that the measurements rest on.
void save_metrics(const std::string& path, const std::string& target, const std::vector<MetricEntry>& metrics,
                  const Provenance& provenance, const std::vector<ExchangeReference>& exchanges = {});

struct MetricsRecord {
  std::string target;  // what was measured: "scene", an object id or a row key
  std::vector<MetricEntry> metrics;
};
MetricsRecord load_metrics(const std::string& path);

}  // namespace physmas

#endif
