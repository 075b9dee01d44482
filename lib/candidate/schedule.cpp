#include "candidate/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace physmas::candidate {
namespace {

using Kind = ScheduleOperation::Kind;

constexpr double kSlabFraction = 0.2;  // top_press: thickness of the pressed slab
constexpr int kImpulseSubsteps = 4;    // of the base step
constexpr double kSlack = 1e-9;

Kind kind_of(const PlanAction& action, const std::string& plan_file, const std::string& pointer) {
  switch (action.type) {
    case ActionType::translation:
      return Kind::translation;
    case ActionType::top_press:
      return Kind::top_press;
    case ActionType::impulse:
      return Kind::impulse;
    default:
      throw invalid_input({plan_file, pointer + "/type", std::string("\"") + action_name(action.type) + "\"",
                           "translation, top_press or impulse", "the other seven actions are not built yet"});
  }
}

// Index of the first substep that starts at or after `time`.
int first_step(double time, double dt) {
  return static_cast<int>(std::ceil(time / dt * (1 - kSlack)));
}

ScheduleOperation compile_action(const Context& context, const PlanAction& action, double dt,
                                 const std::string& plan_file, const std::string& pointer) {
  ScheduleOperation op;
  op.kind = kind_of(action, plan_file, pointer);
  const char* field = action.source.empty() ? "/target" : "/source";
  const std::string& reference = action.source.empty() ? action.target : action.source;
  const std::vector<int> rows = resolve_rows(context.inventory, reference);
  for (const ActiveRow& a : context.active) {
    if (std::find(rows.begin(), rows.end(), a.row) != rows.end()) op.rows.push_back(a.row);
  }
  if (op.rows.empty()) {
    throw invalid_input({plan_file, pointer + field, "\"" + reference + "\", which has no active row",
                         "an object or a row with Gaussians"});
  }
  op.velocity = action.magnitude * action.direction;
  op.start = action.start;
  op.end = std::min(action.end, context.run.time.duration());
  if (op.kind == Kind::impulse) op.end = std::min(op.end, op.start + kImpulseSubsteps * context.run.time.substep_dt);
  if (op.kind == Kind::top_press) op.slab_fraction = kSlabFraction;
  op.start_step = first_step(op.start, dt);
  // However short, an action acts for one step.
  op.end_step = std::max(first_step(op.end, dt), op.start_step + 1);
  return op;
}

}  // namespace

std::vector<ScheduleOperation> compile_schedule(const Context& context, const Configuration& configuration,
                                                const TimestepResult& timestep, const std::string& plan_file,
                                                std::vector<Omission>& omitted) {
  std::vector<ScheduleOperation> schedule;
  for (size_t i = 0; i < context.plan.actions.size(); ++i) {
    const PlanAction& action = context.plan.actions[i];
    const std::string pointer = "/actions/" + std::to_string(i);
    kind_of(action, plan_file, pointer);
    if (!(action.end > action.start)) {
      throw invalid_input({plan_file, pointer + "/end", fmt::format("{}", action.end),
                           fmt::format("a time after /start, {} s", action.start)});
    }
    if (action.start >= context.run.time.duration()) {
      omitted.push_back({fmt::format("action {} of the plan", i), "it starts when the run has ended"});
      continue;
    }
    schedule.push_back(compile_action(context, action, timestep.dt, plan_file, pointer));
  }
  for (const auto& [key, eta] : configuration.projection) {
    ScheduleOperation op;
    op.kind = Kind::structure_projection;
    op.rows = {context.inventory.find_row(key)};
    op.eta = eta;
    schedule.push_back(op);
  }
  for (const std::string& key : configuration.retention) {
    ScheduleOperation op;
    op.kind = Kind::interface_retention;
    op.rows = {context.inventory.find_row(key)};
    for (const ActiveRow& a : context.active) {
      const bool same_object = context.inventory_row(a).object == context.inventory.rows[op.rows[0]].object;
      if (same_object && a.row != op.rows[0]) op.neighbours.push_back(a.row);
    }
    schedule.push_back(op);
  }
  return schedule;
}

}  // namespace physmas::candidate
