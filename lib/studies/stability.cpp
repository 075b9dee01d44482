#include "studies/stability.h"

#include <atomic>
#include <cmath>

#include "base/team.h"
#include "bind/timing.h"
#include "mpm/material/constitutive.h"

namespace physmas::studies {
namespace {

using mpm::Vec3d;

constexpr double kLargestStep = 2e-4;  // s: the base step Δt₀ of the run specification
constexpr int kFewestSteps = 50;       // of a run by the paper's rule: fewer could not show that it diverges
// Root mean square between a run and its reference. Not asked of the extremes: what bursts from a deformed start falls
// differently with every step.
constexpr double kCellsApart = 0.5;
constexpr double kMostStretch = 1e4;  // an entry of F beyond this is no deformation

// The branches whose stress is the gradient of their energy: only there does kinetic + elastic + potential mean
// something. The stress cut of the others leaves trial energy that was never put in.
bool all_have_potential(const mpm::Problem& problem) {
  for (const mpm::Material& m : problem.materials)
    if (!mpm::has_potential(m.branch)) return false;
  return true;
}

// Watches one run frame by frame.
struct Judge {
  const mpm::Problem& problem;
  bool elastic_counts;
  double start = 0, scale = 0, surplus = 0;
  bool finite = true, inside = true;
  double largest_F = 0;
  std::vector<Vec3d> x;  // at the last frame

  explicit Judge(const mpm::Problem& p) : problem(p), elastic_counts(all_have_potential(p)) {}

  void look(const mpm::Frame& frame) {
    const double low = 2 * problem.domain.dx() * (1 - 1e-6), high = problem.domain.length - low;
    for (size_t i = 0; i < frame.state.size(); ++i) {
      const Vec3d& at = frame.state.x[i];
      for (int a = 0; a < 3; ++a) {
        finite = finite && std::isfinite(at[a]) && std::isfinite(frame.state.v[i][a]);
        // The rest frame shows particles where the caller put them.
        inside = inside && (frame.index == 0 || (at[a] >= low && at[a] <= high));
      }
      const double entry = mpm::largest_entry(frame.state.F[i]);
      finite = finite && std::isfinite(entry);
      largest_F = std::max(largest_F, entry);
    }
    x = frame.state.x;
  }

  // Energy that came from nowhere, as a share of what may move: kinetic energy at the start, what is stored in F, a
  // fall through the block's surroundings, and what actions put in.
  void weigh(const mpm::Balance& b) {
    const double elastic = elastic_counts ? b.elastic : 0;
    const double total = b.kinetic + elastic + b.gravity - 2 * b.control_work;
    if (b.frame == 0) {
      start = total + (elastic_counts ? 0 : b.elastic);
      scale = b.kinetic + b.elastic + b.mass * mpm::norm(problem.domain.gravity) * problem.domain.dx();
    }
    const double moved = scale + b.control_work;
    if (moved > 0) surplus = std::max(surplus, (total - start) / moved);
  }
};

mpm::Result run_judged(const StabilityCase& c, const mpm::Timing& timing, mpm::Precision precision,
                       const Device& device, Judge& judge) {
  mpm::Options options;
  options.precision = precision;
  options.device = device;
  const mpm::Result result = mpm::run(c.problem, timing, options, [&](const mpm::Frame& frame) { judge.look(frame); });
  for (const mpm::Balance& b : result.balances) judge.weigh(b);
  return result;
}

mpm::Timing make_timing(const StabilityCase& c, bool cfl, double paper_dt) {
  mpm::Timing t;
  t.frames = c.frames;
  t.rule = cfl ? mpm::StepRule::cfl : mpm::StepRule::fixed;
  const int intervals = std::max(1, c.frames - 1);
  const double dt = cfl ? kLargestStep : paper_dt;
  t.frame_dt = (cfl ? c.duration : std::max(c.duration, kFewestSteps * dt)) / intervals;
  t.substeps = bind::whole_substeps(dt, t.frame_dt);
  // Exactly the paper's step, also where a frame is not a whole number of them.
  if (!cfl) t.frame_dt = t.substeps * dt;
  return t;
}

// How many substeps the solver took to see what a look at the total energy after every substep sees.
long long detection_delay(const StabilityCase& c, mpm::Timing timing, mpm::Precision precision, const Device& device,
                          long long found) {
  timing.frame_dt /= timing.substeps;
  timing.substeps = 1;
  timing.frames = static_cast<int>(std::min(found + 2, 20000LL));
  mpm::Options options;
  options.precision = precision;
  options.device = device;
  const mpm::Result result = mpm::run(c.problem, timing, options, [](const mpm::Frame&) {});
  Judge judge(c.problem);
  long long first = result.status == mpm::Status::diverged ? std::min(result.first_bad_step, found) : found;
  for (const mpm::Balance& b : result.balances) {
    judge.weigh(b);
    if (judge.surplus > kEnergyFromNowhere) {
      first = std::min(first, b.frame - 1LL);
      break;
    }
  }
  return found - first;
}

// What a run is compared with: the same case by cfl in double, over the same time.
struct Reference {
  double duration = 0;
  std::vector<Vec3d> x;
};

// Root mean square distance of the particles of two runs [m].
double distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += mpm::dot(a[i] - b[i], a[i] - b[i]);
  return a.empty() ? 0 : std::sqrt(sum / static_cast<double>(a.size()));
}

StabilityRun run_case(const StabilityCase& c, bool cfl, mpm::Precision precision, const Device& device, double paper_dt,
                      Reference& reference) {
  const mpm::Timing timing = make_timing(c, cfl, paper_dt);
  Judge judge(c.problem);
  const mpm::Result result = run_judged(c, timing, precision, device, judge);
  StabilityRun run;
  run.study = c.study;
  run.name = c.name;
  run.rule = cfl ? "cfl" : "paper";
  run.precision = precision == mpm::Precision::full ? "double" : "float";
  const mpm::Material& m = c.problem.materials[0];
  run.branch = mpm::branch_name(m.branch);
  run.E = m.E, run.nu = m.nu, run.rho = m.rho;
  run.stable = result.status == mpm::Status::stable;
  run.reason = result.reason;
  run.first_bad_step = result.first_bad_step;
  run.steps = result.steps;
  run.dt = result.dt;
  run.smallest_dt = result.history.smallest_dt;
  run.largest_dt = result.history.largest_dt;
  run.retries = result.history.retries;
  run.limit = stable_limit(m, c.problem.domain.dx());
  for (const mpm::Material& other : c.problem.materials)
    run.limit = std::min(run.limit, stable_limit(other, c.problem.domain.dx()));
  run.min_J = result.min_J;
  run.max_J = result.max_J;
  run.surplus = judge.surplus;
  run.outside = result.particles_outside;
  if (!run.stable) {
    // Under a stress cone the surplus never shows: everything since the start is late.
    run.late = run.reason == "step" ? run.first_bad_step + 1
                                    : detection_delay(c, timing, precision, device, run.first_bad_step);
    return run;
  }
  const double duration = timing.frame_dt * (timing.frames - 1);
  if (cfl && precision == mpm::Precision::full) reference = {duration, judge.x};
  if (duration != reference.duration) {
    // A whole number of the paper's steps, or a run that was made longer.
    Judge other(c.problem);
    mpm::Timing same = make_timing(c, true, paper_dt);
    same.frame_dt = timing.frame_dt;
    same.substeps = bind::whole_substeps(kLargestStep, same.frame_dt);
    run_judged(c, same, mpm::Precision::full, device, other);
    reference = {duration, other.x};
  }
  run.apart = distance(judge.x, reference.x) / c.problem.domain.dx();
  if (!judge.finite) {
    run.garbage = "a number that is not finite";
  } else if (!judge.inside) {
    run.garbage = "a particle outside the domain";
  } else if (judge.largest_F > kMostStretch) {
    run.garbage = "an entry of F above 1e4";
  } else if (judge.surplus > kEnergyFromNowhere) {
    run.garbage = "energy from nowhere";
  } else if (c.study != "extremes" && run.apart > kCellsApart) {
    run.garbage = "another motion than with steps by cfl";
  }
  return run;
}

}  // namespace

std::vector<StabilityRun> run_stability(const std::vector<StabilityCase>& cases, const PaperStep& paper_step,
                                        const Device& device, const std::function<void(long, long)>& progress) {
  constexpr int kRunsPerCase = 4;
  const int count = static_cast<int>(cases.size());
  std::vector<StabilityRun> runs(static_cast<size_t>(kRunsPerCase) * count);
  std::vector<std::exception_ptr> failures(count);
  std::atomic<long> done{0};
  Team team(device.threads > 0 ? device.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  team.for_each(count, [&](int i) {
    try {
      const double paper_dt = paper_step(cases[i].problem.materials);
      Reference reference;
      int k = kRunsPerCase * i;
      for (const bool cfl : {true, false})
        for (const mpm::Precision precision : {mpm::Precision::full, mpm::Precision::single})
          runs[k++] = run_case(cases[i], cfl, precision, {device.kind, 1}, paper_dt, reference);
    } catch (...) {
      failures[i] = std::current_exception();
    }
    progress(++done, count);
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  return runs;
}

}  // namespace physmas::studies
