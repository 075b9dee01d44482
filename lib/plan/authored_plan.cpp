#include "plan/authored_plan.h"

#include "records/json.h"

namespace physmas::plan {

Plan authored_plan(const std::string& path, const std::string& prompt, const Inventory& inventory) {
  const Plan given = load_plan(path, inventory);
  Plan plan;
  plan.prompt = prompt;
  plan.resolved = true;
  plan.actions = given.actions;
  plan.materials = given.materials;
  plan.still = given.still && given.actions.empty();
  plan.proposal = {{"agent", "authored"}};
  plan.corrections.push_back("the actions are those of a plan that was given (--plan), not what the prompt says");
  if (given.prompt != prompt) plan.corrections.push_back("that plan was made for another prompt: " + given.prompt);
  return plan;
}

}  // namespace physmas::plan
