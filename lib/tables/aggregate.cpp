#include "tables/aggregate.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/error.h"
#include "records/metrics.h"

namespace physmas::tables {
namespace {

const std::vector<std::string> kMotionMetrics = {"trajectory_nrmse", "area_log_rmse", "strain_rmse"};
const std::vector<std::string> kMetrics = {"clip_sim", "trajectory_nrmse", "area_log_rmse", "strain_rmse"};

bool is_motion(const std::string& metric) {
  return std::find(kMotionMetrics.begin(), kMotionMetrics.end(), metric) != kMotionMetrics.end();
}

// One score of a metric per registered object, or per single record.
Score combine(const EvaluationCase& c, const std::string& metric, const std::map<std::string, Score>& by_target) {
  if (by_target.empty()) return Score::invalid("no record");
  if (!is_motion(metric) || !c.multi_object) {
    if (by_target.size() > 1) return Score::invalid("records of more than one target");
    return by_target.begin()->second;
  }
  std::vector<Score> scores;
  for (const std::string& object : c.objects) {
    const auto found = by_target.find(object);
    if (found == by_target.end()) return Score::invalid("no record of the object " + object);
    scores.push_back(found->second);
  }
  return mean_of(scores);
}

}  // namespace

Aggregate::Aggregate(const Evaluation& evaluation, const std::vector<UprRecord>& rates) : evaluation_(evaluation) {
  for (size_t i = 0; i < evaluation.cases.size(); ++i) {
    sets_.push_back({evaluation.cases[i].multi_object, evaluation.cases[i].profiles});
    for (const EvaluationMethod& method : evaluation.methods) {
      if (evaluation.cases[i].results.count(method.id) > 0) read_result(i, method.id);
    }
  }
  leave_out_unmeasured();
  for (const UprRecord& record : rates) add_rates(record);
}

void Aggregate::leave_out_unmeasured() {
  for (const std::string& metric : kMetrics) {
    const std::vector<std::string>& required = evaluation_.required;
    if (measured_.count(metric) > 0 || std::find(required.begin(), required.end(), metric) != required.end()) continue;
    for (ResultScores& row : results_) row.score.erase(metric);
  }
}

void Aggregate::read_result(size_t case_index, const std::string& method) {
  const EvaluationCase& c = evaluation_.cases[case_index];
  const EvaluationResult& result = c.results.at(method);
  ResultScores row;
  row.case_index = case_index;
  row.method = method;
  row.done = result.done;
  row.reason = result.reason;
  std::map<std::string, std::map<std::string, Score>> scores;  // metric -> target -> score
  for (const std::string& path : result.metrics) {
    const MetricsRecord record = load_metrics(path);
    for (const MetricEntry& metric : record.metrics) {
      measured_.insert(metric.name);
      const Score score = metric.valid ? Score::of(metric.value) : Score::invalid(metric.reason);
      if (!scores[metric.name].emplace(record.target, score).second)
        throw invalid_input({path, "/metrics/" + metric.name, "a second record of \"" + record.target + "\"",
                             "one per result, metric and target"});
    }
  }
  for (const std::string& metric : kMetrics)
    row.score[metric] = result.done ? combine(c, metric, scores[metric]) : Score::invalid("failed: " + result.reason);
  if (!result.done) {
    row.score["seconds"] = Score::invalid("failed: " + result.reason);
  } else if (result.seconds > 0) {
    row.score["seconds"] = Score::of(result.seconds);
  }
  results_.push_back(std::move(row));
}

void Aggregate::add_rates(const UprRecord& rates) {
  const std::string source = "the rates of the study \"" + rates.study + "\"";
  const std::vector<std::string>& methods = rates.study == "ablation" ? evaluation_.ablation : evaluation_.comparison;
  if (std::set<std::string>(methods.begin(), methods.end()) !=
      std::set<std::string>(rates.methods.begin(), rates.methods.end()))
    throw invalid_input({source, "/methods", "other methods", "those of the manifest's \"" + rates.study + "\""});
  std::map<std::string, const UprRecord::Case*> by_id;
  for (const UprRecord::Case& c : rates.cases) by_id[c.id] = &c;
  for (ResultScores& row : results_) {
    if (std::find(methods.begin(), methods.end(), row.method) == methods.end()) continue;
    const std::string& id = evaluation_.cases[row.case_index].id;
    const auto found = by_id.find(id);
    if (found == by_id.end()) throw invalid_input({source, "/cases", "no case \"" + id + "\"", "every case"});
    const UprRecord::Case& c = *found->second;
    const auto count = c.counts.find(row.method);
    row.score["upr/" + rates.study] =
        c.responses == 0 || count == c.counts.end()
            ? Score::invalid("no responses")
            : Score::of(100.0 * static_cast<double>(count->second) / static_cast<double>(c.responses));
  }
}

std::vector<std::string> Aggregate::lacking() const {
  std::vector<std::string> list;
  for (const ResultScores& row : results_) {
    const auto require = [&](const std::string& metric) {
      const auto found = row.score.find(metric);
      if (found != row.score.end() && found->second.valid()) return;
      const bool invalid = found != row.score.end() && found->second.state == Score::State::invalid;
      list.push_back(fmt::format("{}, {}: {}: {}", evaluation_.cases[row.case_index].id, row.method, metric,
                                 invalid ? found->second.reason : "no record"));
    };
    const auto is_in = [&](const std::vector<std::string>& methods) {
      return std::find(methods.begin(), methods.end(), row.method) != methods.end();
    };
    const bool multi_object = evaluation_.cases[row.case_index].multi_object;
    for (const std::string& metric : evaluation_.required) {
      // The ablation's table has neither motion metrics nor multi-object cases.
      const bool compared = is_in(evaluation_.comparison), ablated = is_in(evaluation_.ablation) && !multi_object;
      if (metric == "upr") {
        if (compared) require("upr/comparison");
        if (ablated) require("upr/ablation");
      } else if (compared || (ablated && metric == "clip_sim")) {
        require(metric);
      }
    }
  }
  return list;
}

Score Aggregate::reported(const std::string& method, const std::string& metric, const std::string& set) const {
  return reported_score(sets_, set, [&](size_t i) {
    const ResultScores& result = result_of(i, method);
    const auto found = result.score.find(metric);
    return found == result.score.end() ? Score{} : found->second;
  });
}

const ResultScores& Aggregate::result_of(size_t case_index, const std::string& method) const {
  return *std::find_if(results_.begin(), results_.end(),
                       [&](const ResultScores& r) { return r.case_index == case_index && r.method == method; });
}

Table Aggregate::case_table() const {
  Table table;
  table.name = "cases";
  table.corner = "Case";
  table.caption = "Every result, failures included.";
  const std::vector<std::string> metrics = {"clip_sim",       "trajectory_nrmse", "area_log_rmse", "strain_rmse",
                                            "upr/comparison", "upr/ablation",     "seconds"};
  for (const char* name : {"Set", "Method", "Status"}) table.columns.push_back({"", name, {}});
  for (const std::string& metric : metrics) table.columns.push_back({"", metric, {}});
  table.columns.push_back({"", "Why", {}});
  for (const ResultScores& result : results_) {
    const EvaluationCase& c = evaluation_.cases[result.case_index];
    std::string set = c.multi_object ? kMultiObject : "", why = result.done ? "" : result.reason;
    for (const std::string& profile : c.profiles) set += (set.empty() ? "" : " ") + profile;
    Table::Row row{c.id, {{set, {}}, {result.method, {}}, {result.done ? "done" : "failed", {}}}};
    for (const std::string& metric : metrics) {
      const auto found = result.score.find(metric);
      const Score score = found == result.score.end() ? Score{} : found->second;
      row.cells.push_back({"", {{score}}});
      if (result.done && score.state == Score::State::invalid)
        why += fmt::format("{}{}: {}", why.empty() ? "" : "; ", metric, score.reason);
    }
    row.cells.push_back({why, {}});
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace physmas::tables
