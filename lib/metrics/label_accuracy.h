// How many Gaussians got their true row, where the truth is known: scenes that pm-scene synthesised.
#ifndef PHYSMAS_METRICS_LABEL_ACCURACY_H
#define PHYSMAS_METRICS_LABEL_ACCURACY_H

#include <cstdint>
#include <string>
#include <vector>

#include "records/inventory.h"

namespace physmas::metrics {

struct LabelAccuracy {
  std::vector<std::string> truth;            // keys of the true rows
  std::vector<std::string> labels;           // keys of the run's rows, residual ones included
  std::vector<std::vector<long>> confusion;  // [truth][labels] Gaussians
  long gaussians = 0;
  double row_accuracy = 0;            // share of Gaussians whose label has the true key, 0..1
  double object_accuracy = 0;         // share of those whose label belongs to the true object
  long of_row(size_t t) const;        // Gaussians of true row t
  long right_in_row(size_t t) const;  // those of them that got its key
};

// truth: [N] index into truth_inventory.rows; labels: [N] index into inventory.rows. N > 0, equal for both; indices
// are in range. Rows are compared by key: a true row that the run's inventory lacks is wrong everywhere.
LabelAccuracy compare_labels(const Inventory& truth_inventory, const std::vector<int32_t>& truth,
                             const Inventory& inventory, const std::vector<int32_t>& labels);

void save_label_accuracy(const std::string& path, const LabelAccuracy& accuracy, const Provenance& provenance);

// For the terminal: accuracy by row, then where the wrong ones went.
std::string label_table(const LabelAccuracy& accuracy);

}  // namespace physmas::metrics

#endif
