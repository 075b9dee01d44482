#include "mpm/rigid/impact_windows.h"

#include <algorithm>
#include <cmath>

#include "mpm/timestep.h"

namespace physmas::mpm {

namespace {

constexpr int kLongestWindow = 60;  // substeps
constexpr int kMissed = 20;         // substeps in which an impact has not come
constexpr double kFreeSteps = 3000;
// Of a body's momentum along the approach: what it takes for an impact to have come.
constexpr double kHitShare = 0.05;
constexpr double kRestSpeed = 1e-3;  // m/s per substep: contact that gives a body no more is rest, without weight too

}  // namespace

bool ImpactWindows::quiet(const RigidMotion& rigid, const std::vector<Vec3d>& impulse, const Vec3d& gravity,
                          double dt) {
  pushed_.resize(impulse.size(), 0);
  bool rest = true;
  for (size_t b = 0; b < impulse.size(); ++b) {
    const double push = norm(impulse[b]);
    const double mass = rigid.rest(static_cast<int>(b)).mass;
    pushed_[b] += push;
    hit_ = hit_ || pushed_[b] > kHitShare * mass * std::max(kImpactSpeed, rigid.approach());
    rest = rest && push < std::max(mass_ * norm(gravity) * dt, mass * kRestSpeed);
  }
  if (!hit_) return age_ >= kMissed;
  return rest || age_ >= kLongestWindow;
}

StepReport ImpactWindows::advance(Stepper& stepper, int steps, double dt, const TimedControls& controls,
                                  double energy_limit) {
  StepReport total;
  const auto add = [&](const StepReport& part, int substeps) {
    total.steps += substeps;
    total.fault = part.fault;
    total.max_speed = std::max(total.max_speed, part.max_speed);
    total.control_work += part.control_work;
    total.particles_clamped = std::max(total.particles_clamped, part.particles_clamped);
    total.sorts += part.sorts;
    total.energy.add(part.energy);
    total.seconds_particles += part.seconds_particles;
    total.seconds_grid += part.seconds_grid;
    total.seconds_sort += part.seconds_sort;
  };
  RigidMotion& rigid = *stepper.rigid();
  double small = dt;
  for (int b = 0; b < rigid.count(); ++b) small = std::min(small, kWaveShare * rigid.rest(b).limit);
  const int parts = static_cast<int>(std::ceil(dt / small * (1 - 1e-9)));
  while (total.steps < steps && total.fault == StepFault::none) {
    const int at = total.steps;
    const double limit = energy_limit + 2 * total.control_work;
    if (!open_) {
      rigid.allow_windows(budget_ >= 0 && static_cast<double>(history_.small_steps) <
                                              budget_ * static_cast<double>(done_ + at) + kFreeSteps);
      const StepReport report = stepper.advance(
          steps - at, dt, [&](int step, std::vector<Control>& out) { return controls((at + step) * dt, dt, out); },
          limit);
      add(report, report.steps);
      if (!report.impact) break;
      open_ = true;
      hit_ = false;
      age_ = 0;
      pushed_.clear();
      ++history_.windows;
      stepper.hold(false);
      continue;
    }
    const double part = dt / parts;
    const StepReport report = stepper.advance(
        parts, part, [&](int step, std::vector<Control>& out) { return controls(at * dt + step * part, part, out); },
        limit);
    add(report, 1);
    history_.small_steps += report.steps;
    ++history_.steps;
    ++age_;
    if (report.fault != StepFault::none || !quiet(rigid, report.push, rigid.gravity(), dt)) continue;
    stepper.hold(true);
    rigid.measure_rebound();
    open_ = false;
  }
  done_ += total.steps;
  return total;
}

}  // namespace physmas::mpm
