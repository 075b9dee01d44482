#include "metrics/preference.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "metrics/sets.h"
#include "records/labels.h"

namespace physmas::metrics {
namespace {

class Rates {
 public:
  Rates(const StudyKey& key, const std::vector<StudyAnswers>& answers) : key_(key) {
    for (const StudyKey::Case& c : key.cases) sets_.push_back({c.multi_object, c.profiles});
    for (const StudyAnswers& respondent : answers) {
      std::vector<int> chosen(key.cases.size(), -1);
      for (const StudyAnswers::Answer& answer : respondent.answers) {
        const auto c = std::find_if(key.cases.begin(), key.cases.end(),
                                    [&](const StudyKey::Case& k) { return k.id == answer.case_id; });
        const auto m = std::find(key.methods.begin(), key.methods.end(), answer.method);
        chosen[c - key.cases.begin()] = static_cast<int>(m - key.methods.begin());
      }
      chosen_.push_back(std::move(chosen));
    }
  }

  size_t respondents() const { return chosen_.size(); }
  const std::vector<CaseSets>& sets() const { return sets_; }

  // [cases][methods] counts over respondents, each as often as it is listed.
  std::vector<std::vector<long>> counts(const std::vector<size_t>& respondents) const {
    std::vector<std::vector<long>> counts(key_.cases.size(), std::vector<long>(key_.methods.size(), 0));
    for (const size_t h : respondents) {
      for (size_t c = 0; c < counts.size(); ++c) {
        if (chosen_[h][c] >= 0) ++counts[c][chosen_[h][c]];
      }
    }
    return counts;
  }

  // UPR of a method over a set, percent.
  Score upr(const std::vector<std::vector<long>>& counts, const std::string& set, size_t method) const {
    return reported_score(sets_, set, [&](size_t c) {
      long responses = 0;
      for (const long n : counts[c]) responses += n;
      return responses == 0 ? Score{} : Score::of(100.0 * counts[c][method] / responses);
    });
  }

 private:
  const StudyKey& key_;
  std::vector<CaseSets> sets_;
  std::vector<std::vector<int>> chosen_;  // [respondents][cases] method, -1: no answer
};

// Linear interpolation between order statistics.
double percentile(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const size_t below = static_cast<size_t>(at);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

UprRecord preference_rates(const StudyKey& key, const std::vector<StudyAnswers>& answers, long resamples, long seed) {
  const Rates rates(key, answers);
  std::vector<size_t> everyone(rates.respondents());
  for (size_t h = 0; h < everyone.size(); ++h) everyone[h] = h;
  const auto counts = rates.counts(everyone);

  UprRecord record;
  record.study = key.study;
  record.methods = key.methods;
  record.respondents = static_cast<long>(everyone.size());
  record.resamples = resamples;
  record.seed = seed;
  for (size_t c = 0; c < key.cases.size(); ++c) {
    UprRecord::Case entry;
    entry.id = key.cases[c].id;
    for (size_t m = 0; m < key.methods.size(); ++m) {
      entry.counts[key.methods[m]] = counts[c][m];
      entry.responses += counts[c][m];
    }
    if (entry.responses == 0)
      throw invalid_input({"the answers", "case \"" + entry.id + "\"", "no response", "at least one for every case"});
    record.cases.push_back(entry);
  }

  std::vector<std::string> names(kBranchNames.begin(), kBranchNames.end());
  names.insert(names.end(), {kAverage, kMultiObject});
  names.erase(std::remove_if(names.begin(), names.end(),
                             [&](const std::string& set) { return !rates.upr(counts, set, 0).valid(); }),
              names.end());
  const size_t methods = key.methods.size();
  std::vector<std::vector<double>> samples(names.size() * methods);
  Random random(static_cast<uint64_t>(seed));
  for (long k = 0; k < resamples; ++k) {
    std::vector<size_t> drawn(everyone.size());
    for (size_t& h : drawn) h = static_cast<size_t>(random.uniform() * static_cast<double>(everyone.size()));
    const auto drawn_counts = rates.counts(drawn);
    for (size_t s = 0; s < names.size(); ++s) {
      for (size_t m = 0; m < methods; ++m) {
        const Score upr = rates.upr(drawn_counts, names[s], m);
        if (upr.valid()) samples[s * methods + m].push_back(upr.value);
      }
    }
  }
  for (size_t s = 0; s < names.size(); ++s) {
    UprRecord::Set set;
    set.name = names[s];
    for (const CaseSets& c : rates.sets())
      set.cases += names[s] == kAverage ? (c.multi_object ? 0 : 1) : (is_in_set(c, names[s]) ? 1 : 0);
    for (size_t m = 0; m < methods; ++m) {
      std::vector<double>& values = samples[s * methods + m];
      Preference p;
      p.value = p.low = p.high = rates.upr(counts, names[s], m).value;
      std::sort(values.begin(), values.end());
      if (!values.empty()) p.low = percentile(values, 0.025), p.high = percentile(values, 0.975);
      set.upr[key.methods[m]] = p;
    }
    record.sets.push_back(set);
  }
  return record;
}

}  // namespace physmas::metrics
