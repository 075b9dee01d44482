#include "records/actions.h"

#include "base/error.h"

namespace physmas {
namespace {

constexpr bool in_order() {
  for (size_t i = 0; i < kActions.size(); ++i) {
    if (kActions[i].kind != static_cast<ActionType>(i)) return false;
  }
  return true;
}
static_assert(in_order(), "the table has the actions in the order of their enumeration");

}  // namespace

ActionType action_from(const std::string& name) {
  for (const ActionLine& action : kActions) {
    if (name == action.name) return action.kind;
  }
  throw internal_error("an action that the schema should have refused: " + name);
}

}  // namespace physmas
