#include "plan/timetable.h"

#include <fmt/format.h>

#include <algorithm>

namespace physmas::plan {
namespace {

// A stage that nothing is commanded in ("it falls, then ...") takes this share of the run.
constexpr double kIdleStage = 0.35;

}  // namespace

Timetable::Timetable(const RunSpecification& run)
    : whole_(run.time.duration()), impulse_(kImpulseSubsteps * run.time.substep_dt) {}

void Timetable::next_stage() {
  stage_start_ = empty_stage_ ? stage_start_ + kIdleStage * whole_ : std::max(latest_end_, stage_start_);
  empty_stage_ = true;
  ++stages_;
}

std::vector<std::string> Timetable::place(const Event& event, double usual, PlanAction& action) {
  std::vector<std::string> changes;
  const ActionLine& line = action_line(action.type);
  const bool later = stages_ > 1;
  action.start =
      later ? stage_start_ + event.delay.value_or(0) : event.delay.value_or(std::min(line.start, 0.1 * whole_));
  if (!later && action.start > whole_) {
    changes.push_back(
        fmt::format("{} starts at {} s, after the run's end: moved to {} s", line.name, action.start, 0.5 * whole_));
    action.start = 0.5 * whole_;
  }
  double length = usual;
  if (action.type == ActionType::impulse) {
    length = impulse_;
  } else if (event.duration) {
    length = *event.duration;
  } else if (event.angle && action.type == ActionType::torque) {
    length = *event.angle / action.magnitude;
  }
  action.end = action.start + std::max(length, 0.0);
  empty_stage_ = false;
  if (action.type == ActionType::support_hold && !event.duration) {
    action.end = std::max(whole_, action.start);
    return changes;
  }
  latest_end_ = std::max(latest_end_, action.end);
  if (!later) {
    if ((event.duration || event.angle) && action.type != ActionType::impulse && action.end > whole_ * (1 + 1e-12))
      changes.push_back(fmt::format("{} cut at the run's end, {} s", line.name, whole_));
    action.end = std::min(action.end, whole_);
  }
  return changes;
}

void Timetable::fit(std::vector<PlanAction>& actions) {
  if (stages_ == 1 || latest_end_ <= whole_) return;
  factor_ = whole_ / latest_end_;
  for (PlanAction& action : actions) {
    const double length = action.end - action.start;
    const bool holds = action.type == ActionType::support_hold && action.end >= whole_;
    action.start *= factor_;
    action.end =
        holds ? whole_ : std::min(action.start + (action.type == ActionType::impulse ? 1 : factor_) * length, whole_);
  }
}

}  // namespace physmas::plan
