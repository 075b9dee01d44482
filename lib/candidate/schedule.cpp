#include "candidate/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "candidate/compile_action.h"
#include "candidate/stiff_rows.h"

namespace physmas::candidate {
namespace {

using Kind = ScheduleOperation::Kind;

constexpr double kSlack = 1e-9;

// Index of the first substep that starts at or after `time`.
int first_step(double time, double dt) {
  return static_cast<int>(std::ceil(time / dt * (1 - kSlack)));
}

}  // namespace

std::vector<ScheduleOperation> compile_schedule(const Context& context, const Configuration& configuration,
                                                const TimestepResult& timestep, const std::string& plan_file,
                                                std::vector<Omission>& omitted) {
  std::vector<ScheduleOperation> schedule;
  for (size_t i = 0; i < context.plan.actions.size(); ++i) {
    const PlanAction& action = context.plan.actions[i];
    const std::string pointer = "/actions/" + std::to_string(i);
    if (!(action.end > action.start)) {
      throw invalid_input({plan_file, pointer + "/end", fmt::format("{}", action.end),
                           fmt::format("a time after /start, {} s", action.start)});
    }
    if (action.start >= context.run.time.duration()) {
      omitted.push_back({fmt::format("action {} of the plan", i), "it starts when the run has ended"});
      continue;
    }
    ScheduleOperation op = compile_action(context, action, plan_file, pointer);
    if (op.kind == Kind::torque && !context.run.controls.blend_stiff)
      op.enforced = resists_blending(context, configuration.rows, op);
    op.start_step = first_step(op.start, timestep.dt);
    // However short, an action acts for one step.
    op.end_step = std::max(first_step(op.end, timestep.dt), op.start_step + 1);
    schedule.push_back(std::move(op));
  }
  for (const auto& [key, eta] : configuration.projection) {
    ScheduleOperation op;
    op.kind = Kind::structure_projection;
    op.rows = {context.inventory.find_row(key)};
    op.eta = eta;
    op.rigid = context.run.projection.rigid;
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
