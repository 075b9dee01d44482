// From the records of single results to the paper's Tables 1 to 5.
#ifndef PHYSMAS_TABLES_AGGREGATE_H
#define PHYSMAS_TABLES_AGGREGATE_H

#include <map>
#include <set>
#include <string>
#include <vector>

#include "metrics/sets.h"
#include "records/evaluation.h"
#include "records/study.h"
#include "tables/table.h"

namespace physmas::tables {

using metrics::CaseSets;
using metrics::kAverage;
using metrics::kMultiObject;

// One result: a method on a case.
struct ResultScores {
  size_t case_index = 0;  // into Evaluation::cases
  std::string method;
  bool done = false;
  std::string reason;                  // why not
  std::map<std::string, Score> score;  // clip_sim, trajectory_nrmse, area_log_rmse, strain_rmse, seconds,
                                       // upr/comparison, upr/ablation
};

class Aggregate {
 public:
  // Reads every metrics record that the manifest names. A failed result has invalid scores. A metric that is not
  // required and of which no result has a record was not measured: it has no scores, invalid ones neither. Of a
  // multi-object case the motion metrics are the mean over its registered objects; an object without a record makes
  // them invalid. Errors (exit code 3): a record that cannot be read, one that measures a metric and target a second
  // time, rates of a study with other methods or cases.
  Aggregate(const Evaluation& evaluation, const std::vector<UprRecord>& rates);

  const std::vector<ResultScores>& results() const { return results_; }
  // "case, method: metric: reason" for every required metric that a result of a table lacks.
  std::vector<std::string> lacking() const;

  // The row of every result, failures included.
  Table case_table() const;
  // Tables 1 to 5 of the paper; Table 5 only with an ablation.
  std::vector<Table> paper_tables() const;
  // What the paper's tables average away: each motion error per profile, the run time per case, and, since a failure
  // makes its sets invalid, how many there are and the motion errors over the cases of which every method has them.
  std::vector<Table> detail_tables() const;

 private:
  Score reported(const std::string& method, const std::string& metric, const std::string& set) const;
  const ResultScores& result_of(size_t case_index, const std::string& method) const;
  void leave_out_unmeasured();
  void read_result(size_t case_index, const std::string& method);
  void add_rates(const UprRecord& rates);
  Table errors_table(const std::string& metric, const std::string& name, const std::string& caption) const;
  Table case_times_table() const;
  Table common_table() const;
  Table profile_table() const;       // paper, Table "mainquant"
  Table multi_object_table() const;  // paper, Table "multiobject"
  Table runtime_table() const;       // paper, Table "runtime"
  Table motion_table() const;        // paper, Table "physicalmetrics"
  Table ablation_table() const;      // paper, Table "ablation"

  const Evaluation& evaluation_;
  std::set<std::string> measured_;  // metrics of which some record was read
  std::vector<CaseSets> sets_;
  std::vector<ResultScores> results_;  // by case, then in the manifest's order of methods
};

}  // namespace physmas::tables

#endif
