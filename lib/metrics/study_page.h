// A blinded, randomised forced-choice study: one HTML page, videos beside it, and the key to both.
#ifndef PHYSMAS_METRICS_STUDY_PAGE_H
#define PHYSMAS_METRICS_STUDY_PAGE_H

#include <string>

#include "records/evaluation.h"
#include "records/study.h"

namespace physmas::metrics {

// study: "comparison" or "ablation": one trial per case, all methods of that table side by side. Codes are made of
// seed, case and method, and tell neither; the page shuffles cases and cards for every respondent. A failed result has
// a code and no video: its card says so.
StudyKey make_study(const Evaluation& evaluation, const std::string& study, const std::string& seed);

// Writes folder/page/index.html and folder/page/videos/CODE.mp4: the part that respondents get. Errors (exit code 3):
// a result that is done but names no video, or a video that does not decode.
void write_study_page(const std::string& folder, const Evaluation& evaluation, const StudyKey& key);

}  // namespace physmas::metrics

#endif
