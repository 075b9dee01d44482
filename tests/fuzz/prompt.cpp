// Motion prompts: read without an inventory, then planned with one.
#include "../unit/ground_scenes.h"
#include "ground/proposal.h"
#include "ground/scene_inventory.h"
#include "ground/scene_plan.h"
#include "guard.h"

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
  static const ground::SceneGeometry geometry = ground::cubes_at({{"cake", {0, 0, 0}}, {"ball", {0, 0, 2}}}, 1);
  const std::string prompt(reinterpret_cast<const char*>(data), size);
  guard([&] {
    ground::proposal_of(ground::read_prompt(prompt, ground::nouns_of(inventory)));
    Inventory own = ground::inventory_from_prompt(prompt);
    ground::complete_inventory(own, {"front"}, "prompt");
  });
  guard([&] { ground::plan_from_prompt(prompt, inventory, geometry, RunSpecification(), "scene.json"); });
  return 0;
}
