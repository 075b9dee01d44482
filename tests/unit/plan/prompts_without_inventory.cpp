// Prompts of people who have a file and no inventory: there is one part, and what is not an agent is that part.
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "base/words.h"
#include "plan/prompt.h"
#include "plan/scene_inventory.h"
#include "plan/scene_plan.h"
#include "plan/stated_materials.h"
#include "records/labels.h"
#include "records/text_match.h"
#include "unit/plan/scenes.h"

using namespace physmas;
using namespace physmas::plan;

namespace {

struct Understood {
  Inventory inventory;
  Plan plan;
};

Understood understand(const std::string& prompt) {
  Understood result;
  result.inventory = inventory_from_prompt(prompt, "scan");
  complete_inventory(result.inventory, {"front"}, "test");
  result.plan = plan_from_prompt(prompt, result.inventory, cubes_at({}, 0.25), RunSpecification(), "scene.json");
  expect_materials(result.plan.materials, result.inventory);
  return result;
}

// "type axis/slab", one per action, on the only object.
std::string summary(const Understood& understood) {
  std::string text;
  for (const PlanAction& a : understood.plan.actions) {
    CHECK(a.target == understood.inventory.objects[0].id);
    CHECK(a.source.empty());
    const Eigen::Vector3d& d = a.direction;
    const std::string way = d.z() > 0.9    ? "up"
                            : d.z() < -0.9 ? "down"
                            : d.x() > 0.9  ? "right"
                            : d.x() < -0.9 ? "left"
                                           : "depth";
    text += (text.empty() ? "" : "; ") + std::string(action_name(a.type)) + " " + way + (a.slab ? "/slab" : "");
  }
  return text;
}

std::string notes(const Understood& understood) {
  return join(understood.plan.corrections, "\n");
}

}  // namespace

TEST_CASE("plan: without an inventory every noun that is no agent means the one part") {
  const std::vector<std::pair<std::string, std::string>> kTable = {
      {"a hand presses down on the top of the toy", "top_press down"},
      {"press down on the pillow", "top_press down"},
      {"knock over the statue", "torque depth"},
      {"push over the vase", "torque depth"},
      {"the vase tips over", "torque depth"},
      {"blow on the flower", "impulse right"},
      {"two hands stretch the dough", "scale right"},
      {"a hammer hits the figure", "impulse right"},
      {"hit the figure with a stick", "impulse right"},
      {"A ficus in a pot: its leaves move in the wind", "impulse right"},
      {"Simulate the deformation when a user presses on the object with a force of 10 N for 3 seconds",
       "top_press down"},
      {"the toy is thrown into the air", "translation up"},
      {"twist the headstock of the guitar", "torque up/slab; support_hold down/slab"},
      {"hold the bottom and twist the top", "support_hold down/slab; torque up/slab"},
      {"twist the base of the vase", "torque down/slab; support_hold down/slab"},
      {"the base stays fixed while the top is bent to the right", "support_hold down/slab; impulse right"},
      {"the guitar does not move", ""},
      {"the toy falls", ""},
      {"gravity is turned off and the figure is pushed to the left", "translation left"},
      {"the left side of the box is pushed up", "translation up"}};
  for (const auto& entry : kTable) {
    CAPTURE(entry.first);
    CHECK(summary(understand(entry.first)) == entry.second);
  }
}

TEST_CASE("plan: what does not fall first stands on its floor") {
  for (const char* prompt : {"the guitar falls onto the floor", "drop it", "it bounces", "Der Ball faellt", "x"})
    CHECK(starts_in_the_air(prompt));
  for (const char* prompt : {"it does not fall", "press the toy, then it falls", "the statue falls over", "it sways",
                             "the toy stands still"})
    CHECK_FALSE(starts_in_the_air(prompt));
}

TEST_CASE("plan: what is guessed or left out is said") {
  const std::vector<std::pair<std::string, std::string>> kTable = {
      {"push the toy", "no direction for \"push\""},
      {"push the toy to the left", "no strength for \"push\": 0.6 m/s"},
      {"press the toy with a force of 10 N", "not used: \"10 n\""},
      {"lift the toy 2 m", "not used: \"2 m\""},
      {"drop the toy from high above", "not used: \"from high above\""},
      {"shake the toy three times", "not used: \"three times\""},
      {"the toy shatters", "not done: \"shatters\""},
      {"the vase spills", "not done: \"spills\""},
      {"gravity is turned off", "not done: \"turned\" of gravity"},
      {"a weight is dropped on the toy", "not done: \"weight\" is not in the scene"},
      {"push the head of the toy to the left", "\"head\" is a place of toy"},
      {"the toy is sung to", "not done: \"sung\""}};
  for (const auto& entry : kTable) {
    CAPTURE(entry.first);
    const std::string said = notes(understand(entry.first));
    CAPTURE(said);
    CHECK(said.find(entry.second) != std::string::npos);
  }
  CHECK(notes(understand("push the toy gently to the left")).find("no strength") == std::string::npos);
  CHECK(notes(understand("push the toy at 2 m/s to the left")).find("not used") == std::string::npos);
}

TEST_CASE("plan: words of material are evidence for the part that they describe") {
  const auto expected = [](const std::string& prompt) {
    const Understood understood = understand(prompt);
    return join(understood.inventory.rows[0].expected_labels);
  };
  CHECK(expected("a rubber bear bouncing on a wooden surface") == "Rubber");
  CHECK(expected("a sand bear collapsing") == "Sand");
  CHECK(expected("turn it to sand") == "Sand");
  CHECK(expected("the figure turns into jelly") == "Rubber");
  CHECK(expected("press down on the pillow") == "Foam");
  CHECK(expected("the candle melts") == "Plasticine");
  CHECK(expected("hit the vase with a wooden stick") == "");
  CHECK(expected("the hedge sways in the wind") == "");
}

TEST_CASE("plan: what is told one after the other fits into the run") {
  const double whole = RunSpecification().time.duration();
  for (const char* prompt :
       {"press the toy, then lift it, then push it to the left",
        "first someone presses the toy. After that, the toy is lifted. Finally it is pushed to the left."}) {
    CAPTURE(prompt);
    const Plan plan = understand(prompt).plan;
    REQUIRE(plan.actions.size() == 3);
    for (int i = 0; i < 3; ++i) {
      CHECK(plan.actions[i].end - plan.actions[i].start > 0.2 * whole);
      if (i > 0) CHECK(plan.actions[i].start == doctest::Approx(plan.actions[i - 1].end));
    }
    CHECK(plan.actions[2].end == doctest::Approx(whole));
    CHECK(join(plan.corrections).find("one after the other does not fit") != std::string::npos);
  }
  // What belongs to one stage starts with it; what falls has time to.
  const Plan pair = understand("press the toy, then lift it and turn it").plan;
  REQUIRE(pair.actions.size() == 3);
  CHECK(pair.actions[2].start == doctest::Approx(pair.actions[1].start));
  CHECK(understand("the toy falls, then it is pushed to the left").plan.actions[0].start > 0.2 * whole);
  const Plan short_steps = understand("push the toy to the left for 0.3 s, then lift it for 0.4 s").plan;
  CHECK(short_steps.actions[1].start == doctest::Approx(0.3));
  CHECK(short_steps.actions[1].end == doctest::Approx(0.7));
}

TEST_CASE("plan: a prompt that asks for no motion is a plan of its own") {
  for (const char* prompt :
       {"the toy does not move", "the toy stands still", "it stays where it is", "nothing happens"})
    CHECK(understand(prompt).plan.still);
  for (const char* prompt : {"the toy falls", "push the toy", "the toy bounces", "a quiet scene"})
    CHECK_FALSE(understand(prompt).plan.still);
}

TEST_CASE("plan: back and forth are strokes that end where they began") {
  const Plan plan = understand("swing it back and forth").plan;
  REQUIRE(plan.actions.size() == 5);
  double way = 0;
  for (const PlanAction& a : plan.actions)
    way += a.magnitude * (a.end - a.start) * a.direction.dot(plan.actions[0].direction);
  CHECK(std::abs(way) < 1e-9);
  CHECK(plan.actions[1].direction.dot(plan.actions[0].direction) == doctest::Approx(-1));
}

TEST_CASE("plan: stated materials name things of the inventory, and labels of the paper") {
  Inventory inventory = understand("push the toy").inventory;
  CHECK(stated_materials("Rubber", inventory)[0].label == kRubber);
  CHECK(stated_materials("toy=wood", inventory)[0].label == kWood);
  CHECK_THROWS(stated_materials("toy=cheese", inventory));
  CHECK_THROWS(stated_materials("hat=Wood", inventory));
  inventory.rows[0].expected_labels = {"Metal"};
  expect_materials(stated_materials("toy=Wood toy=Foam", inventory), inventory);
  CHECK(join(inventory.rows[0].expected_labels) == "Wood, Foam");
  CHECK(inventory.rows[1].expected_labels.empty());
}

TEST_CASE("records: words of a prompt count whole, names of an inventory as the paper searches them") {
  InventoryRow row;
  row.name = "hedge";
  CHECK(contains_any(row_text(row, {row.name}), {"edge"}));
  row.named_by_prompt = true;
  CHECK_FALSE(contains_any(row_text(row, {row.name}), {"edge"}));
  row.name = "Base_support, left edge";
  CHECK(contains_any(row_text(row, {row.name}), {"edge"}));
  CHECK(contains_any(row_text(row, {row.name}), {"base support"}));
}
