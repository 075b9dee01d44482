// Tables beside the paper's: each motion error per profile set, and the run time of every case.
#include <fmt/format.h>

#include <algorithm>

#include "records/labels.h"
#include "tables/aggregate.h"

namespace physmas::tables {
namespace {

const std::vector<std::string>& motion_errors() {
  static const std::vector<std::string> metrics = {"trajectory_nrmse", "area_log_rmse", "strain_rmse"};
  return metrics;
}

bool has_motion_errors(const ResultScores& result) {
  return std::all_of(motion_errors().begin(), motion_errors().end(), [&](const std::string& metric) {
    const auto found = result.score.find(metric);
    return found != result.score.end() && found->second.valid();
  });
}

}  // namespace

Table Aggregate::errors_table(const std::string& metric, const std::string& name, const std::string& caption) const {
  Table table{name, "Method", caption, {}, {}};
  std::vector<std::string> sets(kBranchNames.begin(), kBranchNames.end());
  sets.insert(sets.end(), {kAverage, kMultiObject});
  for (const std::string& set : sets)
    table.columns.push_back({"", set == kAverage ? "Avg." : set == kMultiObject ? "Multi-object" : set, {}});
  for (const std::string& method : evaluation_.comparison) {
    Table::Row row{evaluation_.method_name(method), {}};
    for (const std::string& set : sets) row.cells.push_back({"", {{reported(method, metric, set), 2}}});
    table.rows.push_back(std::move(row));
  }
  mark_columns(table, false);
  return table;
}

Table Aggregate::case_times_table() const {
  Table table{"times", "Case", "Run time per case in seconds.", {}, {}};
  for (const std::string& method : evaluation_.comparison)
    table.columns.push_back({"", evaluation_.method_name(method), {}});
  for (size_t i = 0; i < evaluation_.cases.size(); ++i) {
    Table::Row row{evaluation_.cases[i].id, {}};
    for (const std::string& method : evaluation_.comparison) {
      const ResultScores& result = result_of(i, method);
      const auto found = result.score.find("seconds");
      row.cells.push_back({"", {{found == result.score.end() ? Score{} : found->second, 1}}});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table Aggregate::common_table() const {
  std::vector<size_t> common[2];  // multi-part, multi-object
  for (size_t i = 0; i < evaluation_.cases.size(); ++i) {
    const bool is_common = std::all_of(evaluation_.comparison.begin(), evaluation_.comparison.end(),
                                       [&](const std::string& m) { return has_motion_errors(result_of(i, m)); });
    if (is_common) common[evaluation_.cases[i].multi_object ? 1 : 0].push_back(i);
  }
  Table table{"common", "Method", "", {}, {}};
  table.caption = fmt::format(
      "Motion errors over the {} multi-part/{} multi-object cases of which every method has them, cases alike; "
      "failures "
      "are counted, not averaged.",
      common[0].size(), common[1].size());
  table.columns.push_back({"", "Failed", {}});
  for (const char* name : {"Trajectory nRMSE", "Area Log RMSE", "Local-strain RMSE"})
    table.columns.push_back({"", name, {"multi-part", "multi-object"}});
  for (const std::string& method : evaluation_.comparison) {
    size_t failed = 0;
    for (size_t i = 0; i < evaluation_.cases.size(); ++i) failed += has_motion_errors(result_of(i, method)) ? 0 : 1;
    Table::Row row{evaluation_.method_name(method), {{fmt::format("{} of {}", failed, evaluation_.cases.size()), {}}}};
    for (const std::string& metric : motion_errors()) {
      Cell cell;
      for (const std::vector<size_t>& cases : common) {
        std::vector<Score> scores;
        for (const size_t i : cases) scores.push_back(result_of(i, method).score.at(metric));
        cell.numbers.push_back({mean_of(scores), 3});
      }
      row.cells.push_back(cell);
    }
    table.rows.push_back(std::move(row));
  }
  for (size_t c = 1; c < table.columns.size(); ++c) {
    for (size_t part = 0; part < 2; ++part) {
      std::vector<Number*> numbers;
      for (Table::Row& row : table.rows) numbers.push_back(&row.cells[c].numbers[part]);
      mark_best(numbers, false);
    }
  }
  return table;
}

std::vector<Table> Aggregate::detail_tables() const {
  return {common_table(),
          errors_table("trajectory_nrmse", "trajectory", "Trajectory nRMSE per profile; lower is better."),
          errors_table("area_log_rmse", "area", "Area log-RMSE per profile; lower is better."),
          errors_table("strain_rmse", "strain", "Local-strain RMSE per profile; lower is better."), case_times_table()};
}

}  // namespace physmas::tables
