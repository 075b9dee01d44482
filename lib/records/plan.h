// plan.json: the scene plan Pi, resolved and canonical.
#ifndef PHYSMAS_RECORDS_PLAN_H
#define PHYSMAS_RECORDS_PLAN_H

#include <array>
#include <string>
#include <vector>

#include "records/inventory.h"
#include "records/json.h"

namespace physmas {

// The supported vocabulary (paper, Table "actions"), in the paper's order.
enum class ActionType : int {
  translation = 0,
  top_press,
  radial_spread,
  vertical_compress,
  side_compress,
  drag_pair,
  scale,
  impulse,
  torque,
  support_hold
};
constexpr int kActionCount = 10;
inline constexpr std::array<const char*, kActionCount> kActionNames = {
    "translation", "top_press", "radial_spread", "vertical_compress", "side_compress", "drag_pair",
    "scale",       "impulse",   "torque",        "support_hold"};
inline const char* action_name(ActionType type) {
  return kActionNames[static_cast<int>(type)];
}
// name: one of kActionNames.
ActionType action_from(const std::string& name);

// Which particles of a target follow the puller of a drag_pair: none, those near it at rest, or all.
enum class Follow : int { none = 0, interface, target };
inline constexpr std::array<const char*, 3> kFollowNames = {"none", "interface", "target"};
// name: one of kFollowNames.
Follow follow_from(const std::string& name);

struct PlanAction {
  ActionType type = ActionType::translation;
  std::string source;  // object id or row key that is moved; empty where the target itself is
  std::string target;  // object id (all its rows) or row key
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit, scene axes
  double magnitude = 0;                                 // see schemas/plan.json
  double start = 0, end = 0;                            // seconds, [start, end)
  std::string role = "target";
  bool impact = false;           // the action specifies an impact (readings, "Candidates")
  bool slab = false;             // torque, support_hold: acts on the slab at the end that `direction` points to
  Follow follow = Follow::none;  // drag_pair
};

struct Plan {
  std::string prompt;
  bool resolved = false;
  std::vector<PlanAction> actions;
  Json proposal = Json::object();
  std::vector<std::string> corrections;
  std::vector<Omission> omitted;
};

// References of actions are checked against `inventory`; one that does not resolve is an Error (exit code 3).
Plan load_plan(const std::string& path, const Inventory& inventory);
void save_plan(const std::string& path, const Plan& plan, const Provenance& provenance);

// The entries of /actions in the record `path`, which its schema accepted; errors as of load_plan.
std::vector<PlanAction> actions_from(const Json& list, const Inventory& inventory, const std::string& path);

// Inventory row indices that a reference (object id or row key) means, in row order; empty when it resolves to none.
std::vector<int> resolve_rows(const Inventory& inventory, const std::string& reference);

}  // namespace physmas

#endif
