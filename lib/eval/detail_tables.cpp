// Tables beside the paper's: each motion error per profile set, and the run time of every case.
#include "eval/aggregate.h"
#include "records/labels.h"

namespace physmas::eval {

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

std::vector<Table> Aggregate::detail_tables() const {
  return {errors_table("trajectory_nrmse", "trajectory", "Trajectory nRMSE per profile; lower is better."),
          errors_table("area_log_rmse", "area", "Area log-RMSE per profile; lower is better."),
          errors_table("strain_rmse", "strain", "Local-strain RMSE per profile; lower is better."), case_times_table()};
}

}  // namespace physmas::eval
