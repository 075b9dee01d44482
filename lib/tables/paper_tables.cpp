// The layouts of the paper's Tables 1 to 5.
#include "records/labels.h"
#include "tables/aggregate.h"

namespace physmas::tables {
namespace {

Number upr_number(const Score& score, int decimals) {
  return {score, decimals, true};
}

const std::vector<std::string>& profile_sets() {
  static const std::vector<std::string> sets = [] {
    std::vector<std::string> list(kBranchNames.begin(), kBranchNames.end());
    list.push_back(kAverage);
    return list;
  }();
  return sets;
}

std::string set_heading(const std::string& set) {
  return set == kAverage ? "Avg." : set;
}

}  // namespace

Table Aggregate::profile_table() const {
  Table table{
      "table1", "Method", "Multi-part results: CLIP similarity and user preference rate per profile set.", {}, {}};
  for (const std::string& set : profile_sets()) {
    table.columns.push_back({set_heading(set), "CLIPsim", {}});
    table.columns.push_back({set_heading(set), "UPR", {}});
  }
  for (const std::string& method : evaluation_.comparison) {
    Table::Row row{evaluation_.method_name(method), {}};
    for (const std::string& set : profile_sets()) {
      row.cells.push_back({"", {{reported(method, "clip_sim", set)}}});
      row.cells.push_back({"", {upr_number(reported(method, "upr/comparison", set), set == kAverage ? 1 : 0)}});
    }
    table.rows.push_back(std::move(row));
  }
  mark_columns(table, true);
  table.last_row_apart = true;
  return table;
}

Table Aggregate::multi_object_table() const {
  Table table{
      "table2", "Method", "Multi-object results; higher is better.", {{"", "CLIPsim", {}}, {"", "UPR", {}}}, {}};
  for (const std::string& method : evaluation_.comparison)
    table.rows.push_back({evaluation_.method_name(method),
                          {{"", {{reported(method, "clip_sim", kMultiObject)}}},
                           {"", {upr_number(reported(method, "upr/comparison", kMultiObject), 1)}}}});
  mark_columns(table, true);
  table.last_row_apart = true;
  return table;
}

Table Aggregate::runtime_table() const {
  Table table{
      "table3", "Method", "Mean run time per case after reconstruction; lower is better.", {{"", "Seconds", {}}}, {}};
  for (const std::string& method : evaluation_.comparison) {
    std::vector<Score> seconds;
    long stated = 0;
    for (const ResultScores& result : results_) {
      if (result.method != method) continue;
      const auto found = result.score.find("seconds");
      seconds.push_back(found == result.score.end() ? Score::invalid("not stated") : found->second);
      if (seconds.back().valid()) ++stated;
    }
    const Score mean = stated == 0 ? Score{} : mean_of(seconds);
    table.rows.push_back({evaluation_.method_name(method), {{"", {{mean, 1}}}}});
  }
  mark_columns(table, false);
  return table;
}

Table Aggregate::motion_table() const {
  Table table{"table4", "Method", "Motion and deformation errors, multi-part/multi-object; lower is better.", {}, {}};
  const std::vector<std::string> parts = {"multi-part", "multi-object"};
  for (const char* name : {"Trajectory nRMSE", "Area Log RMSE", "Local-strain RMSE"})
    table.columns.push_back({"", name, parts});
  for (const std::string& method : evaluation_.comparison) {
    Table::Row row{evaluation_.method_name(method), {}};
    for (const char* metric : {"trajectory_nrmse", "area_log_rmse", "strain_rmse"})
      row.cells.push_back({"", {{reported(method, metric, kAverage), 3}, {reported(method, metric, kMultiObject), 3}}});
    table.rows.push_back(std::move(row));
  }
  mark_columns(table, false);
  table.last_row_apart = true;
  return table;
}

Table Aggregate::ablation_table() const {
  Table table{"table5", "Profile", "Six-profile ablation.", {}, {}};
  for (const std::string& method : evaluation_.ablation) {
    table.columns.push_back({evaluation_.method_name(method), "CLIPsim", {}});
    table.columns.push_back({evaluation_.method_name(method), "UPR", {}});
  }
  for (const std::string& set : profile_sets()) {
    Table::Row row{set_heading(set), {}};
    for (const std::string& method : evaluation_.ablation) {
      row.cells.push_back({"", {{reported(method, "clip_sim", set)}}});
      row.cells.push_back({"", {upr_number(reported(method, "upr/ablation", set), set == kAverage ? 1 : 0)}});
    }
    // The methods stand side by side here.
    for (const size_t first : {size_t{0}, size_t{1}}) {
      std::vector<Number*> numbers;
      for (size_t i = first; i < row.cells.size(); i += 2) numbers.push_back(&row.cells[i].numbers[0]);
      mark_best(numbers, true);
    }
    table.rows.push_back(std::move(row));
  }
  table.last_row_apart = true;
  return table;
}

std::vector<Table> Aggregate::paper_tables() const {
  std::vector<Table> tables = {profile_table(), multi_object_table(), runtime_table(), motion_table()};
  if (!evaluation_.ablation.empty()) tables.push_back(ablation_table());
  return tables;
}

}  // namespace physmas::tables
