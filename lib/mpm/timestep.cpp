#include "mpm/timestep.h"

#include <algorithm>

#include "mpm/material/stiffness.h"
#include "mpm/rigid/impact_windows.h"

namespace physmas::mpm {

namespace {

constexpr double kCellsPerStep = 0.2;   // of the fastest particle
constexpr double kStrainPerStep = 0.3;  // dt |C|: one step can neither invert an element nor double it
// A chunk may end with twice the speed and gradient that its step was chosen for.
constexpr double kGrowth = 2;
constexpr int kMostStepsPerChunk = 64;
constexpr int kFewestStepsPerChunk = 4;
constexpr double kCellsPerChunk = 0.5;  // of the particle that was fastest at the start
constexpr int kMostRetries = 10;        // per chunk: a step 1,000 times smaller at least

void add(StepReport& total, const StepReport& part) {
  total.steps += part.steps;
  total.max_speed = std::max(total.max_speed, part.max_speed);
  total.control_work += part.control_work;
  total.particles_clamped = std::max(total.particles_clamped, part.particles_clamped);
  total.energy.add(part.energy);
}

void add_time(StepReport& total, const StepReport& part) {
  total.sorts += part.sorts;
  total.seconds_particles += part.seconds_particles;
  total.seconds_grid += part.seconds_grid;
  total.seconds_sort += part.seconds_sort;
}

}  // namespace

double rest_limit(const MaterialParameters<double>& parameters, double dx) {
  return dx * std::sqrt(parameters.density / rest_stiffness(parameters));
}

double choose_step(const StepBounds& bounds, const Domain& domain, double largest) {
  const double path = kCellsPerStep * domain.dx();
  // dt (speed + g dt) = path
  const double speed = bounds.speed, root = std::sqrt(speed * speed + 4 * norm(domain.gravity) * path);
  double dt = std::min(largest, kWaveShare * bounds.wave);
  if (speed + root > 0) dt = std::min(dt, 2 * path / (speed + root));
  if (bounds.gradient > 0) dt = std::min(dt, kStrainPerStep / bounds.gradient);
  return dt;
}

AdaptiveStepping::AdaptiveStepping(const StepperSetup& setup, double largest_dt, double end, long long max_steps,
                                   ImpactWindows* windows)
    : setup_(setup), largest_dt_(largest_dt), end_(end), max_steps_(max_steps), windows_(windows) {}

bool AdaptiveStepping::admits(const StepBounds& end, const StepReport& report, double dt) const {
  return dt <= end.wave && dt * std::max(end.speed, report.max_speed) <= kGrowth * kCellsPerStep * setup_.domain.dx() &&
         dt * end.gradient <= kGrowth * kStrainPerStep;
}

StepReport AdaptiveStepping::advance(Stepper& stepper, State& state, const ActionPlan& actions, double start,
                                     double duration, double energy_limit) {
  StepReport total;
  State next = state;
  StepBounds bounds = stepper.measure_bounds(state);
  double time = 0;
  while (time < duration) {
    double limit = choose_step(bounds, setup_.domain, largest_dt_);
    for (int attempt = 0;; ++attempt) {
      const double left = duration - time;
      const double substeps = std::max(1.0, std::ceil(left / limit * (1 - 1e-9)));
      const double whole_run = steps_done_ == 0 ? (end_ - start) / limit : substeps;
      const double budget = static_cast<double>(max_steps_ - steps_done_);
      const double dt = left / substeps;
      const double in_chunk = kCellsPerChunk * setup_.domain.dx() / std::max(bounds.speed * dt, 1e-300);
      const int most = in_chunk < kMostStepsPerChunk ? std::max(kFewestStepsPerChunk, static_cast<int>(in_chunk))
                                                     : kMostStepsPerChunk;
      const int steps = substeps < most ? static_cast<int>(substeps) : most;
      if (!(whole_run <= budget) || steps > budget) {
        total.fault = StepFault::budget;
        ++total.steps;  // the one that is not done
        return total;
      }
      const double limit_now = energy_limit + 2 * total.control_work;
      const auto timed = [&](double from, double of, std::vector<Control>& out) {
        return actions.controls(start + time + from, of, out);
      };
      const auto controls = [&](int step, std::vector<Control>& out) {
        return actions.controls(start + time + step * dt, dt, out);
      };
      const ImpactWindows before = windows_ ? *windows_ : ImpactWindows(0, 0);
      const StepReport report = windows_ ? windows_->advance(stepper, steps, dt, timed, limit_now)
                                         : stepper.advance(steps, dt, controls, limit_now);
      steps_done_ += report.steps;
      add_time(total, report);
      bool good = report.fault == StepFault::none;
      StepBounds end;
      if (good) {
        stepper.store(next);
        end = stepper.measure_bounds(next);
        // Where smaller steps do not help, the bound is that of a jump (an element that flips), not of a wave.
        good = attempt == kMostRetries || admits(end, report, dt);
      }
      if (good || attempt == kMostRetries) {
        add(total, report);
        total.fault = report.fault;
        if (!good) return total;
        history_.smallest_dt = history_.smallest_dt > 0 ? std::min(history_.smallest_dt, dt) : dt;
        history_.largest_dt = std::max(history_.largest_dt, dt);
        history_.time += steps * dt;
        history_.steps += steps;
        time = steps == substeps ? duration : time + steps * dt;
        bounds = end;
        std::swap(state, next);
        break;
      }
      if (windows_) {
        stepper.hold(!before.open());
        *windows_ = before;
      }
      stepper.load(state);
      ++history_.retries;
      history_.discarded_steps += report.steps;
      limit = dt / 2;
      if (report.fault == StepFault::none) limit = std::min(limit, choose_step(end, setup_.domain, largest_dt_));
    }
  }
  return total;
}

}  // namespace physmas::mpm
