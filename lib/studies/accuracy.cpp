#include "studies/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "bind/timing.h"
#include "metrics/motion.h"
#include "studies/point_tracks.h"

namespace physmas::studies {

const char* const kAccuracyMetricNames[kAccuracyMetrics] = {"position", "trajectory", "area", "strain", "energy"};
const char* const kAccuracyMetricTexts[kAccuracyMetrics] = {
    "root mean square particle position error / object size", "image-plane trajectory nRMSE, times 100 (paper)",
    "projected-area log-RMSE, times 100 (paper)", "local Green-Lagrange strain RMSE, times 100 (paper)",
    "largest difference of the change of total energy / energy scale of the reference"};

namespace {

// What a run leaves for comparison.
struct Trace {
  std::vector<std::vector<mpm::Vec3d>> position;  // [T][N]
  mpm::Result result;
};

// children: particles per traced one; their mean is traced.
Trace trace(const mpm::Problem& problem, const AccuracySetting& setting, double frame_dt, double duration,
            int children) {
  mpm::Problem p = problem;
  p.domain.n = setting.n;
  mpm::Timing timing;
  timing.frame_dt = frame_dt;
  timing.frames = static_cast<int>(std::lround(duration / frame_dt)) + 1;
  setting.step.apply(p, timing);
  mpm::Options options;
  options.precision = setting.precision;
  options.device = setting.device;
  Trace t;
  t.result = mpm::run(p, timing, options, [&](const mpm::Frame& frame) {
    t.position.push_back(means_of_children(frame.state.x, children));
  });
  return t;
}

class ErrorJudge {
 public:
  ErrorJudge(const AccuracyCase& setup, double spacing, Trace reference)
      : size_(setup.size), reference_(std::move(reference)), tracker_(study_camera(), 0.75 * spacing) {
    queries_ = tracker_.choose_queries(reference_.position.front());
    for (const auto& x : reference_.position) tracker_.add_frame(x, queries_, motion_);
    scale_ = mpm::energy_residual(reference_.result).scale;
  }

  void judge(const Trace& run, double* error) {
    double squares = 0, drift = 0;
    metrics::TargetMotion motion;
    for (size_t t = 0; t < reference_.position.size(); ++t) {
      const auto &a = reference_.position[t], &b = run.position[t];
      for (size_t i = 0; i < a.size(); ++i) squares += dot(b[i] - a[i], b[i] - a[i]);
      drift = std::max(drift, std::fabs(energy_change(run, t) - energy_change(reference_, t)));
      tracker_.add_frame(b, queries_, motion);
    }
    const double samples = static_cast<double>(reference_.position.size() * reference_.position.front().size());
    error[0] = std::sqrt(squares / samples) / size_;
    const metrics::Measurement m[3] = {metrics::trajectory_nrmse(motion_.tracks, motion.tracks),
                                       metrics::area_log_rmse(motion_.areas, motion.areas),
                                       metrics::strain_rmse(motion_.tracks, motion.tracks)};
    for (int k = 0; k < 3; ++k) error[1 + k] = m[k].valid ? m[k].value : -1;
    error[4] = drift / scale_;
  }

 private:
  static double energy_change(const Trace& run, size_t frame) {
    return run.result.balances[frame].energy() - run.result.balances.front().energy();
  }

  double size_, scale_ = 0;
  Trace reference_;
  PointTracker tracker_;
  std::vector<int> queries_;
  metrics::TargetMotion motion_;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

AccuracyStep fixed_step(double dt) {
  return {fmt::format("{:g}", dt), [dt](const mpm::Problem&, mpm::Timing& timing) {
            timing.substeps = bind::whole_substeps(dt, timing.frame_dt);
          }};
}

AccuracyStep cfl_step() {
  return {"cfl", [](const mpm::Problem&, mpm::Timing& timing) {
            timing.rule = mpm::StepRule::cfl;
            timing.substeps = 1;
          }};
}

AccuracyStep paper_step(std::function<double(const std::vector<mpm::Material>&)> paper_dt) {
  return {"paper", [paper_dt = std::move(paper_dt)](const mpm::Problem& problem, mpm::Timing& timing) {
            fixed_step(paper_dt(problem.materials)).apply(problem, timing);
          }};
}

std::string AccuracySetting::id() const {
  return fmt::format("n{}/{}/{}/{}", n, step.name, precision == mpm::Precision::full ? "double" : "float",
                     device.threads);
}

AccuracyPlan accuracy_plan(bool quick, const Device& device,
                           std::function<double(const std::vector<mpm::Material>&)> paper_dt) {
  AccuracyPlan plan;
  const std::vector<int> grids = quick ? std::vector<int>{16, 24} : std::vector<int>{16, 24, 32, 48};
  const std::vector<double> steps =
      quick ? std::vector<double>{4e-4} : std::vector<double>{8e-4, 4e-4, 2e-4, 1e-4, 5e-5};
  plan.spacing = 1.0 / grids.back();  // eight particles per cell of the finest grid
  plan.reference_n = quick ? 32 : 96;
  plan.reference_dt = quick ? 2e-4 : 5e-5;
  plan.repeats = quick ? 1 : 3;
  for (const int n : grids) {
    for (const double dt : steps) plan.settings.push_back({n, fixed_step(dt), mpm::Precision::single, device});
    plan.settings.push_back({n, paper_step(paper_dt), mpm::Precision::single, device});
    plan.settings.push_back({n, cfl_step(), mpm::Precision::single, device});
    plan.settings.push_back({n, fixed_step(2e-4), mpm::Precision::full, device});
    if (device.threads > 1) plan.settings.push_back({n, fixed_step(2e-4), mpm::Precision::single, {device.kind, 1}});
  }
  return plan;
}

AccuracyStudy run_accuracy(const AccuracyCase& setup, const AccuracyPlan& plan, const Device& device,
                           const std::function<void()>& progress) {
  AccuracyStudy study;
  study.setup = setup;
  const AccuracySetting finest{plan.reference_n, fixed_step(plan.reference_dt), mpm::Precision::full, device};
  const mpm::Problem fine = subdivide(setup.problem, plan.spacing);
  Trace reference = trace(fine, finest, plan.frame_dt, setup.duration, 8);
  progress();
  const mpm::Result& r = reference.result;
  if (r.status != mpm::Status::stable)
    throw internal_error("the reference of " + setup.name + " diverged: " + r.reason);
  study.reference = {static_cast<long long>(8 * setup.problem.particles.size()), r.steps,
                     r.seconds_particles + r.seconds_grid + r.seconds_sort};
  ErrorJudge judge(setup, plan.spacing, std::move(reference));
  AccuracySetting doubled = finest;
  doubled.step = fixed_step(2 * plan.reference_dt);
  const Trace check = trace(fine, doubled, plan.frame_dt, setup.duration, 8);
  if (check.result.status == mpm::Status::stable) judge.judge(check, study.reference.doubled_step);
  progress();
  for (const AccuracySetting& setting : plan.settings) {
    AccuracyResult result;
    result.setting = setting;
    for (int k = 0; k < plan.repeats; ++k) {
      const Trace run = trace(setup.problem, setting, plan.frame_dt, setup.duration, 1);
      result.seconds.push_back(run.result.seconds_particles + run.result.seconds_grid + run.result.seconds_sort);
      if (k > 0) continue;  // repeats give the same bytes
      result.steps = run.result.steps;
      result.stable = run.result.status == mpm::Status::stable;
      result.reason = run.result.reason;
      if (result.stable) judge.judge(run, result.error);
    }
    result.median_seconds = median(result.seconds);
    study.results.push_back(std::move(result));
    progress();
  }
  mark_pareto(study.results);
  return study;
}

void mark_pareto(std::vector<AccuracyResult>& results) {
  for (int m = 0; m < kAccuracyMetrics; ++m) {
    for (AccuracyResult& a : results) {
      a.pareto[m] = a.stable && a.error[m] >= 0;
      for (const AccuracyResult& b : results) {
        if (!b.stable || b.error[m] < 0) continue;
        const bool no_worse = b.median_seconds <= a.median_seconds && b.error[m] <= a.error[m];
        const bool better = b.median_seconds < a.median_seconds || b.error[m] < a.error[m];
        if (no_worse && better) a.pareto[m] = false;
      }
    }
  }
}

}  // namespace physmas::studies
