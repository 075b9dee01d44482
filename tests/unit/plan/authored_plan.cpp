// A plan that was given in place of the prompt's.
#include "plan/authored_plan.h"

#include <doctest/doctest.h>

#include <filesystem>

#include "unit/input_error.h"
#include "unit/temporary_folder.h"

using namespace physmas;

TEST_CASE("ground: a given plan is taken as it stands, and says so") {
  const TemporaryFolder folder;
  const std::string file = folder.path() + "/plan.json";
  Inventory inventory;
  inventory.objects = {{"cake", "Cake", "", {}, {}}};
  inventory.rows.emplace_back();
  inventory.rows[0].object = "cake";
  inventory.rows[0].part = "plate";
  Plan written;
  written.prompt = "it falls";
  PlanAction push;
  push.target = "cake/plate";
  push.direction = {0.6, 0, 0.8};
  push.magnitude = 0.21;
  push.end = 0.5;
  written.actions = {push};
  written.still = true;
  Provenance provenance;
  provenance.tool = "test";
  save_plan(file, written, provenance);
  const Plan plan = plan::authored_plan(file, "it rises", inventory);
  CHECK(plan.prompt == "it rises");
  CHECK(plan.resolved);
  REQUIRE(plan.actions.size() == 1);
  CHECK(plan.actions[0].magnitude == 0.21);
  CHECK_FALSE(plan.still);
  REQUIRE(plan.corrections.size() == 2);
  CHECK(plan.corrections[1] == "that plan was made for another prompt: it falls");
  CHECK(plan::authored_plan(file, "it falls", inventory).corrections.size() == 1);
  inventory.rows[0].part = "dish";
  CHECK(message_of([&] { plan::authored_plan(file, "it falls", inventory); }) ==
        file + ": /actions/0/target: found \"cake/plate\", expected an object id or a row key of the inventory");
}
