#include "studies/error_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "bind/timing.h"
#include "metrics/motion.h"
#include "studies/error_cases.h"
#include "studies/point_tracks.h"

namespace physmas::studies {

const char* const kErrorMetricNames[kErrorMetrics] = {"position", "trajectory", "area", "strain"};

namespace {

using mpm::Vec3d;

mpm::Timing timing_of(const AccuracyCase& setup, const ErrorStudyPlan& plan, double dt, mpm::StepRule rule) {
  mpm::Timing timing;
  timing.frame_dt = plan.frame_dt;
  timing.frames = static_cast<int>(std::lround(setup.duration / plan.frame_dt)) + 1;
  timing.substeps = bind::whole_substeps(dt, plan.frame_dt);
  timing.rule = rule;
  return timing;
}

// children: particles per traced one; their mean is traced.
PointPaths trace(const mpm::Problem& problem, const mpm::Timing& timing, const Device& device, size_t children,
                 double* seconds = nullptr) {
  mpm::Options options;
  options.device = device;
  PointPaths paths;
  const mpm::Result result = mpm::run(problem, timing, options, [&](const mpm::Frame& frame) {
    paths.push_back(means_of_children(frame.state.x, children));
  });
  if (result.status != mpm::Status::stable) throw internal_error("a run of the error study diverged: " + result.reason);
  if (seconds) *seconds = result.seconds_total;
  return paths;
}

}  // namespace

std::vector<ErrorCase> error_study_cases(double spacing, bool quick) {
  std::vector<ErrorCase> cases;
  for (AccuracyCase& c : accuracy_cases(spacing)) cases.push_back({std::move(c), false});
  for (AccuracyCase& c : further_cases(spacing)) cases.push_back({std::move(c), false});
  for (AccuracyCase& c : held_out_cases(spacing)) cases.push_back({std::move(c), true});
  if (quick) return {cases.front(), cases.back()};
  return cases;
}

ErrorStudyRow study_error(const ErrorCase& error_case, const ErrorStudyPlan& plan, const Device& device) {
  const AccuracyCase& setup = error_case.setup;
  const double spacing = 1.0 / plan.n;
  mpm::Problem problem = setup.problem;
  problem.domain.n = plan.n;
  ErrorStudyRow row;
  row.name = setup.name, row.text = setup.text, row.held_out = error_case.held_out, row.size = setup.size;

  RefinedPaths paths;
  double seconds = 0, companions = 0;
  paths.fine = trace(problem, timing_of(setup, plan, plan.dt, mpm::StepRule::fixed), device, 1, &seconds);
  for (const int factor : {2, 4}) {
    mpm::Result result;
    (factor == 2 ? paths.half : paths.quarter) =
        run_companion(make_companion(problem, factor), problem.particles, problem.particles.size(),
                      timing_of(setup, plan, factor * plan.dt, mpm::StepRule::cfl), device, &result);
    companions += result.seconds_total;
    if (result.status != mpm::Status::stable) throw internal_error("a companion diverged: " + result.reason);
  }
  row.share = companions / seconds;

  const int finer = plan.finer;
  mpm::Problem fine = subdivide(setup.problem, spacing, finer);
  fine.domain.n = finer * plan.n;
  const PointPaths reference = trace(fine, timing_of(setup, plan, plan.dt / finer, mpm::StepRule::fixed), device,
                                     static_cast<size_t>(finer) * finer * finer);

  const std::vector<int>& row_of = problem.particles.row;
  const Camera camera = study_camera();
  row.estimate[0] = position_error(paths, row_of, -1, orders_of(problem));
  const ImageErrors image = image_errors(paths, camera, 0.75 * spacing, row.estimate[0]);
  row.estimate[1] = image.trajectory, row.estimate[2] = image.area, row.estimate[3] = image.strain;
  // The reference in the place of the run, and the run in that of its companion: the difference is the true error.
  const RefinedPaths true_paths = {reference, paths.fine, paths.fine};
  row.truth[0] = position_error(true_paths, row_of, -1, orders_of(problem)).difference;
  const ImageErrors true_image = image_errors(true_paths, camera, 0.75 * spacing, row.estimate[0]);
  row.truth[1] = true_image.trajectory.difference, row.truth[2] = true_image.area.difference,
  row.truth[3] = true_image.strain.difference;
  return row;
}

Honesty honesty(const std::vector<ErrorStudyRow>& rows, int metric) {
  Honesty h;
  for (const ErrorStudyRow& row : rows) {
    const ErrorEstimate& e = row.estimate[metric];
    if (!e.reason.empty() || e.estimate <= 0) continue;
    const double ratio = row.truth[metric] / e.estimate;
    ++h.cases;
    h.within_two += ratio >= 0.5 && ratio <= 2;
    h.within_bound += row.truth[metric] <= e.bound;
    h.worst = std::max(h.worst, ratio);
  }
  return h;
}

std::string error_study_table(const std::vector<ErrorStudyRow>& rows) {
  std::string text = fmt::format("{:<18}", "true / estimated");
  for (const char* name : kErrorMetricNames) text += fmt::format(" {:>24}", name);
  text += fmt::format(" {:>6}\n", "cost");
  for (const ErrorStudyRow& row : rows) {
    text += fmt::format("{:<18}", row.name + (row.held_out ? " *" : ""));
    for (int m = 0; m < kErrorMetrics; ++m) {
      const double scale = m == 0 ? 100 / row.size : 1;
      const ErrorEstimate& e = row.estimate[m];
      text += fmt::format(" {:>24}", e.reason.empty() ? fmt::format("{:.2f} / {:.2f} = {:.2f}", scale * row.truth[m],
                                                                    scale * e.estimate, row.truth[m] / e.estimate)
                                                      : "none");
    }
    text += fmt::format(" {:>5.0f}%\n", 100 * row.share);
  }
  text += fmt::format("{:<18}", "within two");
  for (int m = 0; m < kErrorMetrics; ++m) {
    const Honesty h = honesty(rows, m);
    text += fmt::format(" {:>24}", fmt::format("{} of {}, most {:.2f}", h.within_two, h.cases, h.worst));
  }
  text += fmt::format("\n{:<18}", "within the bound");
  for (int m = 0; m < kErrorMetrics; ++m) {
    const Honesty h = honesty(rows, m);
    text += fmt::format(" {:>24}", fmt::format("{} of {}", h.within_bound, h.cases));
  }
  return text + "\n* written when the estimate was done; position in % of the object's size\n";
}

}  // namespace physmas::studies
