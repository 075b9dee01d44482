#include "metrics/label_accuracy.h"

#include <doctest/doctest.h>

using namespace physmas;

namespace {

Inventory inventory(const std::vector<std::pair<std::string, std::string>>& rows) {
  Inventory i;
  for (const auto& [object, part] : rows) {
    InventoryRow row;
    row.object = object;
    row.part = part;
    i.rows.push_back(row);
  }
  return i;
}

}  // namespace

TEST_CASE("eval: labels are compared by key, and rows that a run lacks are wrong") {
  const Inventory truth = inventory({{"a", "x"}, {"a", "y"}, {"b", "x"}});
  // Another order, no b/x, a residual row.
  const Inventory run = inventory({{"a", "y"}, {"a", "x"}, {"b", "residual"}});
  const metrics::LabelAccuracy accuracy =
      metrics::compare_labels(truth, {0, 0, 0, 1, 2, 2, 2, 2}, run, {1, 1, 0, 0, 2, 2, 2, 1});
  CHECK(accuracy.row_accuracy == 3.0 / 8);
  CHECK(accuracy.object_accuracy == 7.0 / 8);
  CHECK(accuracy.confusion[0] == std::vector<long>{1, 2, 0});
  CHECK(accuracy.right_in_row(0) == 2);
  CHECK(accuracy.right_in_row(2) == 0);
  CHECK(accuracy.of_row(2) == 4);
}
