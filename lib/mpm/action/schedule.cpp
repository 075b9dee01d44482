#include "mpm/action/schedule.h"

#include <map>

#include "base/error.h"

namespace physmas::mpm {

ActionPlan::ActionPlan(const std::vector<Action>& actions, const Particles& rest)
    : actions_(actions), group_of_(rest.size(), 0), groups_(1) {
  for (size_t a = 0; a < actions_.size(); ++a) {
    regions_.push_back(std::visit([&](const auto& action) { return select_region(action, rest); }, actions_[a]));
    // A group splits into the particles that this action moves and those that it does not.
    std::map<std::uint16_t, std::uint16_t> with_action;
    for (const int i : regions_[a].particles) {
      const auto [it, fresh] = with_action.try_emplace(group_of_[i], static_cast<std::uint16_t>(groups_.size()));
      if (fresh) {
        if (groups_.size() > 0xffff) throw internal_error("more than 65,535 combinations of actions");
        std::vector<int> members = groups_[it->first];
        members.push_back(static_cast<int>(a));
        groups_.push_back(std::move(members));
      }
      group_of_[i] = it->second;
    }
  }
}

bool ActionPlan::controls(double time, double dt, std::vector<Control>& out) const {
  out.assign(groups_.size(), {});
  bool busy = false;
  for (size_t g = 1; g < groups_.size(); ++g) {
    for (const int a : groups_[g]) {
      std::visit([&](const auto& action) { add_control(action, regions_[a], time, dt, out[g]); }, actions_[a]);
    }
    busy = busy || !out[g].idle();
  }
  return busy;
}

}  // namespace physmas::mpm
