// Error against run time: fixed cases over grid size, time step, precision and threads, against a refined reference.
#ifndef PHYSMAS_STUDIES_ACCURACY_H
#define PHYSMAS_STUDIES_ACCURACY_H

#include <functional>
#include <string>
#include <vector>

#include "studies/accuracy_cases.h"

namespace physmas::studies {

// How substeps are chosen: fills `timing` (frame_dt is set) for a problem.
struct AccuracyStep {
  std::string name;  // "2e-4", "paper", "cfl"
  std::function<void(const mpm::Problem&, mpm::Timing&)> apply;
};
AccuracyStep fixed_step(double dt);
AccuracyStep cfl_step();
// paper_dt: the paper's step [s] for these materials.
AccuracyStep paper_step(std::function<double(const std::vector<mpm::Material>&)> paper_dt);

struct AccuracySetting {
  int n = 0;  // cells per axis
  AccuracyStep step;
  mpm::Precision precision = mpm::Precision::single;
  Device device;
  std::string id() const;  // n32/2e-4/float/2
};

struct AccuracyPlan {
  double spacing = 0;  // m, between particles
  std::vector<AccuracySetting> settings;
  int reference_n = 0;
  double reference_dt = 0;  // s; in double precision, with eight particles for each
  double frame_dt = 0.02;   // s
  int repeats = 3;
};
// The study's settings: every grid with every fixed step in float, and on every grid double precision, one thread and
// the rules. device: of the runs that are not about threads, and of the references; its threads are given.
AccuracyPlan accuracy_plan(bool quick, const Device& device,
                           std::function<double(const std::vector<mpm::Material>&)> paper_dt);

// Errors against the reference, over all output frames. -1: could not be measured.
constexpr int kAccuracyMetrics = 5;
extern const char* const kAccuracyMetricNames[kAccuracyMetrics];
extern const char* const kAccuracyMetricTexts[kAccuracyMetrics];

struct AccuracyResult {
  AccuracySetting setting;
  bool stable = false;
  std::string reason;  // why not
  long long steps = 0;
  double error[kAccuracyMetrics] = {-1, -1, -1, -1, -1};
  std::vector<double> seconds;  // stepping only, one per repeat
  double median_seconds = 0;
  bool pareto[kAccuracyMetrics] = {};  // nothing stable is both faster and closer to the reference
};

struct AccuracyReference {
  long long particles = 0, steps = 0;
  double seconds = 0;
  // Errors of the same run with twice the step: how far the reference itself depends on it. Errors of that size mean
  // nothing.
  double doubled_step[kAccuracyMetrics] = {-1, -1, -1, -1, -1};
};

struct AccuracyStudy {
  AccuracyCase setup;
  AccuracyReference reference;
  std::vector<AccuracyResult> results;  // in the plan's order
};

// Runs one case; progress is called after every run.
AccuracyStudy run_accuracy(const AccuracyCase& setup, const AccuracyPlan& plan, const Device& device,
                           const std::function<void()>& progress);

// Marks the results of a study that are Pareto-optimal in (median_seconds, error), per metric.
void mark_pareto(std::vector<AccuracyResult>& results);

}  // namespace physmas::studies

#endif
