// Whether the estimated discretisation error is the true one: cases with a fine reference.
#ifndef PHYSMAS_STUDIES_ERROR_STUDY_H
#define PHYSMAS_STUDIES_ERROR_STUDY_H

#include <functional>
#include <string>
#include <vector>

#include "base/device.h"
#include "studies/accuracy_cases.h"
#include "studies/discretisation_error.h"

namespace physmas::studies {

constexpr int kErrorMetrics = 4;
extern const char* const kErrorMetricNames[kErrorMetrics];  // position, trajectory, area, strain

struct ErrorCase {
  AccuracyCase setup;
  bool held_out = false;  // written when the estimate was done
};
// The five cases of the accuracy study and six more, with which the orders were fixed, and four that were held out.
// quick: one of the first and one of the last.
std::vector<ErrorCase> error_study_cases(double spacing, bool quick);

struct ErrorStudyRow {
  std::string name, text;
  bool held_out = false;
  ErrorEstimate estimate[kErrorMetrics];
  double truth[kErrorMetrics] = {};  // against the reference, in the estimates' units
  double size = 0;                   // m: what position is divided by
  double share = 0;                  // run time of both companions over that of the run
};

struct ErrorStudyPlan {
  int n = 48;  // cells of the run; the reference has `finer` times as many, and as many particles per cell
  int finer = 3;
  double dt = 2e-4;  // s; the reference's is `finer` times smaller
  double frame_dt = 0.02;
};
ErrorStudyRow study_error(const ErrorCase& setup, const ErrorStudyPlan& plan, const Device& device);

// Of the valid estimates of a metric: how many truths lie within a factor of two, and the largest truth / estimate.
struct Honesty {
  int cases = 0, within_two = 0, within_bound = 0;
  double worst = 0;
};
Honesty honesty(const std::vector<ErrorStudyRow>& rows, int metric);
std::string error_study_table(const std::vector<ErrorStudyRow>& rows);

}  // namespace physmas::studies

#endif
