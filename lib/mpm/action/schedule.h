// The compiled schedule Γ of a candidate: substep actions and output-frame projections.
#ifndef PHYSMAS_MPM_ACTION_SCHEDULE_H
#define PHYSMAS_MPM_ACTION_SCHEDULE_H

#include <cstdint>
#include <variant>
#include <vector>

#include "mpm/action/action_compress.h"
#include "mpm/action/action_drag.h"
#include "mpm/action/action_impulse.h"
#include "mpm/action/action_spread.h"
#include "mpm/action/action_torque.h"
#include "mpm/action/action_velocity.h"
#include "mpm/action/projection.h"

namespace physmas::mpm {

using Action = std::variant<Translation, SlabMotion, ScaleSlab, Impulse, RadialSpread, VerticalCompress, SideCompress,
                            DragFollow, Torque>;

struct Schedule {
  std::vector<Action> actions;
  std::vector<StructureProjection> projections;  // at most one per row, applied in this order
  std::vector<InterfaceRetention> retentions;    // applied after the projections, in this order
};

// Actions resolved to particles. Particles under the same set of actions share a control group; group 0 has none.
class ActionPlan {
 public:
  ActionPlan(const std::vector<Action>& actions, const Particles& rest);

  const std::vector<std::uint16_t>& group_of() const { return group_of_; }  // [N]
  int group_count() const { return static_cast<int>(groups_.size()); }
  // What each group is asked to do in the substep [time, time + dt). False when every group is idle.
  bool controls(double time, double dt, std::vector<Control>& out) const;

 private:
  std::vector<Action> actions_;
  std::vector<Region> regions_;  // per action
  std::vector<std::uint16_t> group_of_;
  std::vector<std::vector<int>> groups_;  // actions of each group, in schedule order
};

}  // namespace physmas::mpm

#endif
