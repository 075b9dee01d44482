// The study without object-part state: objects become one part each.
#include "plan/one_part.h"

#include <doctest/doctest.h>

using namespace physmas;

namespace {

InventoryRow part(const std::string& object, const std::string& name, std::vector<std::string> labels) {
  InventoryRow row;
  row.object = object;
  row.part = row.name = name;
  row.expected_labels = std::move(labels);
  return row;
}

Mask mask(std::vector<uint8_t> pixels, double confidence) {
  return {static_cast<int>(pixels.size()), 1, std::move(pixels), confidence, "test"};
}

}  // namespace

TEST_CASE("ground: parts collapse to their objects in inventory, masks and plan") {
  Inventory inventory;
  inventory.objects = {{"cake", "Cake", "dessert", {}, {}}, {"ball", "Ball", "", {}, {}}};
  inventory.rows = {part("cake", "plate", {"Ceramic", "Glass"}), part("cake", "sponge", {"Foam", "Glass"}),
                    part("ball", "ball", {"Rubber"}), part("cake", "residual", {})};
  inventory.rows[3].residual = true;
  std::vector<ViewMasks> views = {
      {"front",
       {mask({255, 255, 255, 0}, 0.9), Mask()},
       {mask({255, 0, 0, 0}, 0.5), mask({0, 255, 0, 0}, 0.7), mask({0, 0, 0, 255}, 0.6), Mask()}},
      {"left", {Mask(), Mask()}, {mask({255, 0, 0, 0}, 0.5), mask({0, 255, 0, 0}, 0.7), Mask(), Mask()}}};
  Plan plan;
  PlanAction push;
  push.source = "cake/plate";
  push.target = "cake/sponge";
  plan.actions = {push};
  plan::collapse_parts(inventory, views, plan);

  REQUIRE(inventory.rows.size() == 3);
  CHECK(inventory.rows[0].key() == "cake/whole");
  CHECK(inventory.rows[0].structural_role == "dessert");
  CHECK(inventory.rows[0].expected_labels == std::vector<std::string>{"Ceramic", "Glass", "Foam"});
  CHECK(inventory.rows[1].key() == "ball/whole");
  CHECK(inventory.rows[2].residual);
  // The object's own mask where there is one, else the union of its parts with their mean confidence.
  CHECK(views[0].rows[0].pixels == std::vector<uint8_t>{255, 255, 255, 0});
  CHECK(views[0].rows[1].pixels == std::vector<uint8_t>{0, 0, 0, 255});
  CHECK(views[1].rows[0].pixels == std::vector<uint8_t>{255, 255, 0, 0});
  CHECK(views[1].rows[0].confidence == doctest::Approx(0.6));
  CHECK(views[1].rows[1].empty());
  CHECK(plan.actions[0].target == "cake");
  CHECK(plan.actions[0].source.empty());
  CHECK(plan.corrections.size() == 2);
}
