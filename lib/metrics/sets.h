// The reported sets of an evaluation: six profiles, their macro-average, and the multi-object cases (paper,
// "Evaluation Protocol").
#ifndef PHYSMAS_METRICS_SETS_H
#define PHYSMAS_METRICS_SETS_H

#include <functional>
#include <string>
#include <vector>

namespace physmas::metrics {

// A number, the reason why there is none, or nothing that could be measured (a set without a case).
struct Score {
  enum class State { absent, invalid, valid } state = State::absent;
  double value = 0;
  std::string reason;  // of an invalid one
  bool valid() const { return state == State::valid; }
  static Score of(double value) { return {State::valid, value, ""}; }
  static Score invalid(const std::string& reason) { return {State::invalid, 0, reason}; }
};

// The unweighted mean. One invalid score makes it invalid: nothing is dropped or imputed. Absent without scores.
Score mean_of(const std::vector<Score>& scores);

// What decides to which sets a case belongs.
struct CaseSets {
  bool multi_object = false;
  std::vector<std::string> profiles;
};

// A reported set by name: a profile ("Jelly"), or kMultiObject.
inline const char* const kMultiObject = "multi-object";
inline const char* const kAverage = "average";
bool is_in_set(const CaseSets& sets, const std::string& name);

// Mean over the cases of the set; score_of: the score of case i.
Score set_score(const std::vector<CaseSets>& cases, const std::string& name,
                const std::function<Score(size_t)>& score_of);
// kAverage: the mean of the six profile scores, absent unless every profile has a case. Any other name: set_score.
Score reported_score(const std::vector<CaseSets>& cases, const std::string& name,
                     const std::function<Score(size_t)>& score_of);

}  // namespace physmas::metrics

#endif
