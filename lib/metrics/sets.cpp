#include "metrics/sets.h"

#include <algorithm>

#include "records/labels.h"

namespace physmas::metrics {

Score mean_of(const std::vector<Score>& scores) {
  double sum = 0;
  long count = 0;
  for (const Score& s : scores) {
    if (s.state == Score::State::invalid) return s;
    if (!s.valid()) continue;
    sum += s.value;
    ++count;
  }
  return count == 0 ? Score{} : Score::of(sum / static_cast<double>(count));
}

bool is_in_set(const CaseSets& sets, const std::string& name) {
  if (name == kMultiObject) return sets.multi_object;
  return !sets.multi_object && std::find(sets.profiles.begin(), sets.profiles.end(), name) != sets.profiles.end();
}

Score set_score(const std::vector<CaseSets>& cases, const std::string& name,
                const std::function<Score(size_t)>& score_of) {
  std::vector<Score> scores;
  for (size_t i = 0; i < cases.size(); ++i) {
    if (is_in_set(cases[i], name)) scores.push_back(score_of(i));
  }
  return mean_of(scores);
}

Score reported_score(const std::vector<CaseSets>& cases, const std::string& name,
                     const std::function<Score(size_t)>& score_of) {
  if (name != kAverage) return set_score(cases, name, score_of);
  std::vector<Score> profiles;
  for (const char* profile : kBranchNames) {
    profiles.push_back(set_score(cases, profile, score_of));
    if (profiles.back().state == Score::State::absent) return {};
  }
  return mean_of(profiles);
}

}  // namespace physmas::metrics
