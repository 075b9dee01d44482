// Motion prompts: read without an inventory, then planned with one.
#include "guard.h"
#include "plan/proposal.h"
#include "plan/scene_inventory.h"
#include "plan/scene_plan.h"
#include "unit/plan/scenes.h"

namespace {

using namespace physmas;

// A cake of two parts and a ball.
Inventory cake_and_ball() {
  Inventory inventory;
  for (const char* id : {"cake", "ball"}) {
    inventory.objects.emplace_back();
    inventory.objects.back().id = inventory.objects.back().name = id;
  }
  for (const auto& [object, part] : {std::pair("cake", "sponge"), {"cake", "icing"}, {"ball", "ball"}}) {
    inventory.rows.emplace_back();
    inventory.rows.back().object = object;
    inventory.rows.back().part = inventory.rows.back().name = part;
  }
  return inventory;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Inventory inventory = cake_and_ball();
  static const plan::SceneGeometry geometry = plan::cubes_at({{"cake", {0, 0, 0}}, {"ball", {0, 0, 2}}}, 1);
  const std::string prompt(reinterpret_cast<const char*>(data), size);
  guard([&] {
    plan::proposal_of(plan::read_prompt(prompt, plan::nouns_of(inventory)));
    Inventory own = plan::inventory_from_prompt(prompt, "scene");
    plan::complete_inventory(own, {"front"}, "prompt");
  });
  guard([&] { plan::plan_from_prompt(prompt, inventory, geometry, RunSpecification(), "scene.json"); });
  return 0;
}
