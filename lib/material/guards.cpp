#include "material/guards.h"

#include <algorithm>

#include "material/label_scores.h"
#include "records/json.h"
#include "records/support.h"

namespace physmas::material {
namespace {

// Thresholds as the paper prints them.
constexpr double kExpectedProbability = 0.18;
constexpr double kCapFactor = 1.75, kCapMargin = 0.20;

constexpr double kVlmConfidence = 0.60;
constexpr int kVlmViews = 3;
constexpr double kTopProbability = 0.75;
constexpr double kRoleConfidence = 0.50, kRoleMargin = 0.10;
constexpr double kPosterior = 0.20, kPosteriorFactor = 1.50, kPosteriorGap = 0.18;

constexpr double kElasticTotal = 0.70, kElasticMaximum = 0.50;
constexpr double kElasticExpectedFraction = 0.50;

bool is_elastic_solid(int label) {
  return kLabels[label].branch == Branch::metal;
}

bool holds(const std::vector<int>& labels, int label) {
  return std::find(labels.begin(), labels.end(), label) != labels.end();
}

// The tests of one guard: each comparison is recorded with its value and limit, and all must hold.
class Tests {
 public:
  void require(bool passed, const char* what, const Json& value, const Json& limit) {
    list_.push_back({{"test", what}, {"value", value}, {"limit", limit}, {"passed", passed}});
    passed_ = passed_ && passed;
  }
  void at_least(const char* what, double value, double limit) { require(value >= limit, what, value, limit); }
  void at_most(const char* what, double value, double limit) { require(value <= limit, what, value, limit); }
  bool passed() const { return passed_; }
  const Json& list() const { return list_; }

 private:
  Json list_ = Json::array();
  bool passed_ = true;
};

// m^exp: the expected label with the highest posterior; the expected order breaks ties.
int best_expected(const EvidenceRow& evidence) {
  int best = evidence.expected_labels.front();
  for (int label : evidence.expected_labels) {
    if (evidence.probability(label) > evidence.probability(best)) best = label;
  }
  return best;
}

EvidenceRow::Guard expected_guard(const EvidenceRow& evidence, int mode) {
  EvidenceRow::Guard guard{"expected", false, mode, Json::object()};
  guard.measured["label_before"] = kLabels[mode].name;
  if (evidence.expected_labels.empty()) {
    guard.measured["expected_label"] = nullptr;
    return guard;
  }
  const int expected = best_expected(evidence);
  const double p = evidence.probability(expected);
  Tests tests;
  tests.require(!holds(evidence.expected_labels, mode), "the label before is not expected", kLabels[mode].name,
                "outside the expected labels");
  tests.at_least("P(expected) at least", p, kExpectedProbability);
  tests.at_most("P(label before) at most Cap", evidence.probability(mode), std::max(kCapFactor * p, p + kCapMargin));
  guard.measured["expected_label"] = kLabels[expected].name;
  guard.measured["tests"] = tests.list();
  guard.applied = tests.passed();
  if (guard.applied) guard.label = expected;
  return guard;
}

// The most probable label of a record; record order breaks ties.
std::pair<int, double> top_of(const LabelScores& probabilities) {
  return *std::max_element(probabilities.begin(), probabilities.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
}

EvidenceRow::Guard multi_view_guard(const EvidenceRow& evidence, const std::vector<ValidVlmRecord>& vlm, int before) {
  EvidenceRow::Guard guard{"multi-view", false, before, Json::object()};
  guard.measured["label_before"] = kLabels[before].name;
  guard.measured["records"] = Json::array();
  const double p_before = evidence.probability(before);
  double best = -1;
  for (const ValidVlmRecord& record : vlm) {
    const auto [v, p_top] = top_of(record.probabilities);
    const double p = evidence.probability(v), role = value(evidence.role_lookup, v);
    Tests tests;
    tests.at_least("confidence at least", record.confidence, kVlmConfidence);
    tests.at_least("canonical views at least", record.canonical_views, kVlmViews);
    tests.at_least("top-label probability at least", p_top, kTopProbability);
    tests.require(holds(evidence.expected_labels, v), "the top label is expected", kLabels[v].name,
                  "among the expected labels");
    tests.require(v != before, "the top label is another than before", kLabels[v].name, kLabels[before].name);
    tests.at_least("R(v) at least", role, kRoleConfidence);
    tests.at_least("R(v) at least R(before) + 0.10", role, value(evidence.role_lookup, before) + kRoleMargin);
    tests.at_least("P(v) at least", p, kPosterior);
    tests.at_most("P(before) at most 1.5 P(v)", p_before, kPosteriorFactor * p);
    tests.at_most("P(before) - P(v) at most", p_before - p, kPosteriorGap);
    const double product = record.confidence * p_top * p;
    guard.measured["records"].push_back({{"record", record.index},
                                         {"label", kLabels[v].name},
                                         {"tests", tests.list()},
                                         {"eligible", tests.passed()},
                                         {"product", product}});
    if (tests.passed() && product > best) {
      best = product;
      guard.applied = true;
      guard.label = v;
    }
  }
  return guard;
}

EvidenceRow::Guard elastic_solid_guard(const EvidenceRow& evidence, const InventoryRow& row,
                                       const std::vector<ValidVlmRecord>& vlm, int before) {
  EvidenceRow::Guard guard{"elastic-solid", false, before, Json::object()};
  guard.measured["label_before"] = kLabels[before].name;
  double fraction = 1;
  if (!evidence.expected_labels.empty()) {
    const auto count =
        std::count_if(evidence.expected_labels.begin(), evidence.expected_labels.end(), is_elastic_solid);
    fraction = static_cast<double>(count) / evidence.expected_labels.size();
  }
  Tests tests;
  tests.require(!is_elastic_solid(before), "the label before is no elastic solid", kLabels[before].name,
                "outside the Metal branch");
  const bool structural = guard_structural(row);
  tests.require(structural, "the row is structural", structural, true);
  tests.at_least("expected-label elastic-solid fraction at least", fraction, kElasticExpectedFraction);
  Json records = Json::array();
  bool strong = false;
  for (const ValidVlmRecord& record : vlm) {
    double total = 0, maximum = 0;
    for (const auto& [label, p] : record.probabilities) {
      if (!is_elastic_solid(label)) continue;
      total += p;
      maximum = std::max(maximum, p);
    }
    Tests strength;
    strength.at_least("canonical views at least", record.canonical_views, kVlmViews);
    strength.at_least("confidence at least", record.confidence, kVlmConfidence);
    strength.at_least("elastic-solid probability at least", total, kElasticTotal);
    strength.at_least("largest elastic-solid probability at least", maximum, kElasticMaximum);
    strong = strong || strength.passed();
    records.push_back({{"record", record.index}, {"tests", strength.list()}, {"strong", strength.passed()}});
  }
  tests.require(strong, "a strong elastic-solid record exists", strong, true);
  guard.measured["tests"] = tests.list();
  guard.measured["records"] = records;
  guard.applied = tests.passed();
  if (guard.applied) {
    // The stored posterior is sorted, so its first elastic solid is the arg max with the stored tie order.
    guard.label = std::find_if(evidence.posterior.begin(), evidence.posterior.end(), [](const auto& entry) {
                    return is_elastic_solid(entry.first);
                  })->first;
  }
  return guard;
}

}  // namespace

void apply_guards(EvidenceRow& evidence, const InventoryRow& row, const std::vector<ValidVlmRecord>& vlm) {
  evidence.guards.push_back(expected_guard(evidence, evidence.posterior.front().first));
  evidence.guards.push_back(multi_view_guard(evidence, vlm, evidence.guards.back().label));
  evidence.guards.push_back(elastic_solid_guard(evidence, row, vlm, evidence.guards.back().label));
  evidence.label = evidence.guards.back().label;
  evidence.confidence = evidence.probability(evidence.label);
}

}  // namespace physmas::material
