// User Preference Rate (paper, Eq. supp-upr) from the answers of a forced-choice study.
#ifndef PHYSMAS_METRICS_PREFERENCE_H
#define PHYSMAS_METRICS_PREFERENCE_H

#include <vector>

#include "records/study.h"

namespace physmas::metrics {

// Counts per case, and per reported set (six profiles, their average, multi-object; those that have cases) the mean of
// the per-case shares. Intervals: 95 % percentile bootstrap over respondents, who are drawn with all their answers; a
// case that no drawn respondent answered is left out of that draw. resamples >= 1.
// Errors (exit code 3): a case without a single response.
UprRecord preference_rates(const StudyKey& key, const std::vector<StudyAnswers>& answers, long resamples, long seed);

}  // namespace physmas::metrics

#endif
