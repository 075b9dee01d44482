#include "metrics/label_accuracy.h"

#include <fmt/format.h>

#include <algorithm>

#include "records/json.h"

namespace physmas::metrics {

long LabelAccuracy::of_row(size_t t) const {
  long sum = 0;
  for (const long count : confusion[t]) sum += count;
  return sum;
}

long LabelAccuracy::right_in_row(size_t t) const {
  const auto found = std::find(labels.begin(), labels.end(), truth[t]);
  return found == labels.end() ? 0 : confusion[t][found - labels.begin()];
}

LabelAccuracy compare_labels(const Inventory& truth_inventory, const std::vector<int32_t>& truth,
                             const Inventory& inventory, const std::vector<int32_t>& labels) {
  LabelAccuracy accuracy;
  accuracy.truth = truth_inventory.row_keys();
  accuracy.labels = inventory.row_keys();
  accuracy.confusion.assign(accuracy.truth.size(), std::vector<long>(accuracy.labels.size(), 0));
  accuracy.gaussians = static_cast<long>(truth.size());
  long objects = 0, rows = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    ++accuracy.confusion[truth[i]][labels[i]];
    objects += truth_inventory.rows[truth[i]].object == inventory.rows[labels[i]].object;
  }
  for (size_t t = 0; t < accuracy.truth.size(); ++t) rows += accuracy.right_in_row(t);
  accuracy.row_accuracy = static_cast<double>(rows) / static_cast<double>(truth.size());
  accuracy.object_accuracy = static_cast<double>(objects) / static_cast<double>(truth.size());
  return accuracy;
}

void save_label_accuracy(const std::string& path, const LabelAccuracy& accuracy, const Provenance& provenance) {
  Json json;
  json["gaussians"] = accuracy.gaussians;
  json["row_accuracy"] = accuracy.row_accuracy;
  json["object_accuracy"] = accuracy.object_accuracy;
  json["labels"] = accuracy.labels;
  json["confusion"] = Json::array();
  for (size_t t = 0; t < accuracy.truth.size(); ++t) {
    const long count = accuracy.of_row(t);
    json["confusion"].push_back(
        {{"key", accuracy.truth[t]},
         {"gaussians", count},
         {"accuracy", count > 0 ? Json(double(accuracy.right_in_row(t)) / double(count)) : Json()},
         {"labelled", accuracy.confusion[t]}});
  }
  save_record(path, "labels", provenance, json);
}

std::string label_table(const LabelAccuracy& accuracy) {
  std::string text = fmt::format("{:<28} {:>9} {:>9}  labelled otherwise\n", "true row", "Gaussians", "right");
  for (size_t t = 0; t < accuracy.truth.size(); ++t) {
    const long count = accuracy.of_row(t);
    std::string others;
    for (size_t k = 0; k < accuracy.labels.size(); ++k) {
      if (accuracy.confusion[t][k] > 0 && accuracy.labels[k] != accuracy.truth[t])
        others += fmt::format(" {} {}", accuracy.labels[k], accuracy.confusion[t][k]);
    }
    text +=
        fmt::format("{:<28} {:>9} {:>9} {}\n", accuracy.truth[t], count,
                    count > 0 ? fmt::format("{:.4f}", double(accuracy.right_in_row(t)) / double(count)) : "-", others);
  }
  return text + fmt::format("row accuracy {:.4f}, object accuracy {:.4f} over {} Gaussians\n", accuracy.row_accuracy,
                            accuracy.object_accuracy, accuracy.gaussians);
}

}  // namespace physmas::metrics
