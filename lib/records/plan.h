// plan.json: the scene plan Pi, resolved and canonical.
#ifndef PHYSMAS_RECORDS_PLAN_H
#define PHYSMAS_RECORDS_PLAN_H

#include <string>
#include <vector>

#include "records/actions.h"
#include "records/inventory.h"
#include "records/json.h"
#include "records/labels.h"

namespace physmas {

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

// What the prompt says that a thing is made of.
struct PlanMaterial {
  std::string target;  // object id (all its rows) or row key
  int label = 0;       // index into kLabels
  std::string word;    // the word that says so
};

struct Plan {
  std::string prompt;
  bool resolved = false;
  std::vector<PlanAction> actions;
  std::vector<PlanMaterial> materials;
  bool still = false;  // the prompt asks for no motion
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
