#include "plan/scene_plan.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "base/words.h"
#include "plan/scene_inventory.h"
#include "scene/camera.h"
#include "unit/plan/scenes.h"

using namespace physmas;
using namespace physmas::plan;

namespace {

InventoryRow row(const std::string& object, const std::string& part, const std::string& name) {
  InventoryRow r;
  r.object = object;
  r.part = part;
  r.name = name;
  return r;
}

// A hammer above a cake, a ball left of a glass, a sunflower; and the floor.
Inventory workshop() {
  Inventory inventory;
  const std::vector<std::pair<std::string, std::string>> objects = {{"hammer", "claw hammer"},
                                                                    {"cake", "strawberry cake"},
                                                                    {"ball", "rubber ball"},
                                                                    {"drink", "glass of juice"},
                                                                    {"sunflower", "potted sunflower"}};
  for (const auto& [id, name] : objects) {
    InventoryObject object;
    object.id = id;
    object.name = name;
    inventory.objects.push_back(object);
  }
  inventory.rows = {row("hammer", "head", "hammer head"),
                    row("hammer", "handle", "handle"),
                    row("cake", "sponge", "sponge"),
                    row("cake", "strawberries", "strawberries"),
                    row("ball", "ball", "ball"),
                    row("drink", "glass", "glass wall"),
                    row("drink", "juice", "juice"),
                    row("sunflower", "pot", "pot"),
                    row("sunflower", "petals", "flower petals"),
                    row("sunflower", "disc", "flower disc"),
                    row("sunflower", "head", "seed head")};
  complete_inventory(inventory, {"front"}, "test");
  return inventory;
}

SceneGeometry geometry() {
  return cubes_at({{"hammer", {0, 0, 2}}, {"cake", {0, 0, 0.5}}, {"ball", {-2, 0, 0.5}}, {"drink", {2, 0, 0.5}}}, 0.25);
}

Plan plan_of(const std::string& prompt) {
  return plan_from_prompt(prompt, workshop(), geometry(), RunSpecification(), "scene.json");
}

// "type source>target direction*", one per action.
std::string summary(const Plan& plan) {
  std::string text;
  for (const PlanAction& a : plan.actions) {
    std::string direction = "?";
    const std::vector<std::pair<Eigen::Vector3d, std::string>> names = {{{0, 0, 1}, "up"},      {{0, 0, -1}, "down"},
                                                                        {{1, 0, 0}, "right"},   {{-1, 0, 0}, "left"},
                                                                        {{0, -1, 0}, "toward"}, {{0, 1, 0}, "away"}};
    for (const auto& [axis, name] : names) {
      if ((axis - a.direction).norm() < 1e-9) direction = name;
    }
    text += (text.empty() ? "" : "; ") + std::string(action_name(a.type)) + " " + a.source + ">" + a.target + " " +
            direction + (a.impact ? "*" : "");
  }
  return text;
}

std::string refusal(const std::string& prompt) {
  try {
    plan_of(prompt);
  } catch (const Error& e) {
    CHECK(e.code() == ExitCode::invalid_input);
    return e.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("ground: prompts and what they compile to") {
  const std::vector<std::pair<std::string, std::string>> kTable = {
      {"a hand presses down on the top of the cake", "top_press >cake down"},
      {"Press the cake.", "top_press >cake down"},
      {"the cake is gently pressed from above", "top_press >cake down"},
      {"someone squashes the strawberries of the cake", "top_press >cake/strawberries down"},
      {"push down on the cake", "top_press >cake down"},
      {"the hammer falls and hits the cake", "translation hammer>cake down*"},
      {"the hammer drops onto the cake and smashes it", "translation hammer>cake down*"},
      {"drop the hammer onto the cake", "translation hammer>cake down*"},
      {"the cake is hit by the hammer", "translation hammer>cake down*"},
      {"hit the cake with the hammer", "translation hammer>cake down*"},
      {"the ball rolls into the glass", "translation ball>drink right*"},
      {"throw the ball at the glass of juice", "translation ball>drink right*"},
      {"the ball flies toward the glass", "translation >ball right"},
      {"the glass is struck by the rubber ball", "translation ball>drink right*"},
      {"push the ball to the left", "translation >ball left"},
      {"push the ball to the left and press the cake", "translation >ball left; top_press >cake down"},
      {"lift the ball", "translation >ball up"},
      {"the ball slides forward", "translation >ball toward"},
      {"move the ball along +x", "translation >ball right"},
      {"kick the ball to the right", "impulse >ball right*"},
      {"the ball gets kicked hard away", "impulse >ball away*"},
      {"give the ball a push to the left", "translation >ball left"},
      {"the wind blows the sunflower from the left", "impulse >sunflower right*"},
      {"the wind pushes the flower of the potted sunflower to the right",
       "impulse >sunflower/petals right*; impulse >sunflower/disc right*"},
      {"the sunflower sways in the wind", "impulse >sunflower right*"},
      {"the hammer's head is nudged up", "impulse >hammer/head up*"},
      {"the ball falls onto the floor and bounces", ""},
      {"the cake topples", "torque >cake away"},
      {"knock over the ball to the left", "torque >ball toward"},
      {"the ball rolls over the cake", "translation ball>cake right*"},
      {"throw the ball into the air", "translation >ball up"},
      {"pull the cake apart", "scale >cake right"},
      {"the cake shatters", ""},
      {"a weight is dropped on the cake", "top_press >cake down"},
      {"the sunflower springs back", ""},
      {"turn the ball into snow", ""},
      {"gravity is turned off", ""},
      {"let the hammer fall", ""},
      {"the ball does not roll", ""},
      {"a quiet scene", ""},
      {"from above, press the cake", "top_press >cake down"},
  };
  for (const auto& entry : kTable) {
    const auto &prompt = entry.first, &expected = entry.second;
    CAPTURE(prompt);
    std::string found;
    try {
      found = summary(plan_of(prompt));
    } catch (const Error& e) {
      found = e.what();
    }
    CHECK(found == expected);
  }
}

TEST_CASE("ground: every action of the vocabulary has words") {
  const std::vector<std::pair<std::string, std::string>> kTable = {
      {"twist the ball", "torque >ball up; support_hold >ball down"},
      {"twist the seed head of the sunflower", "torque >sunflower/head up"},
      {"the ball spins to the right", "torque >ball down"},
      {"spin the ball clockwise", "torque >ball down"},
      {"rotate the ball counterclockwise", "torque >ball up"},
      {"the ball rotates forward", "torque >ball right"},
      {"squeeze the cake", "side_compress >cake right; side_compress >cake left"},
      {"press the cake from the left", "side_compress >cake right"},
      {"squash the cake sideways", "side_compress >cake right"},
      {"stretch the ball", "scale >ball right"},
      {"the ball stretches upwards", "scale >ball up"},
      {"the ball shrinks", "scale >ball right"},
      {"drag the ball to the left", "drag_pair >ball left"},
      {"pull the ball up", "drag_pair >ball up"},
      {"the hammer drags the cake to the left", "drag_pair hammer>cake left*"},
      {"hold the cake", "support_hold >cake down"},
      {"the glass holds the ball", "support_hold >drink down"},
      {"hold the pot and twist the flower petals", "support_hold >sunflower/pot down; torque >sunflower/petals up"},
      {"the cake melts", "radial_spread >cake up"},
      {"compress the cake", "vertical_compress >cake down"},
      {"the hammer twists the cake", "torque >cake up"},
      {"the hammer squeezes the cake", "translation hammer>cake down*"}};
  for (const auto& entry : kTable) {
    const auto &prompt = entry.first, &expected = entry.second;
    CAPTURE(prompt);
    std::string found;
    try {
      found = summary(plan_of(prompt));
    } catch (const Error& e) {
      found = e.what();
    }
    CHECK(found == expected);
  }
  const Plan twist = plan_of("twist the ball");
  CHECK(twist.actions[0].slab);
  CHECK(twist.actions[1].slab);
  CHECK(twist.actions[1].role == "support");
  CHECK(twist.actions[1].end == doctest::Approx(RunSpecification().time.duration()));
  CHECK_FALSE(plan_of("spin the ball").actions[0].slab);
  CHECK(plan_of("the hammer drags the cake to the left").actions[0].follow == Follow::target);
  CHECK(plan_of("drag the ball to the left").actions[0].follow == Follow::none);
}

TEST_CASE("ground: strengths of ratios scale the change, and everything stays within its bounds") {
  CHECK(plan_of("compress the cake").actions[0].magnitude == doctest::Approx(0.6));
  CHECK(plan_of("gently compress the cake").actions[0].magnitude == doctest::Approx(0.8));
  CHECK(plan_of("compress the cake violently").actions[0].magnitude == doctest::Approx(0.2));
  CHECK(plan_of("stretch the ball").actions[0].magnitude == doctest::Approx(1.5));
  CHECK(plan_of("the ball shrinks").actions[0].magnitude == doctest::Approx(1 / 1.5));
  CHECK(plan_of("stretch the ball hard").actions[0].magnitude == doctest::Approx(2));
  CHECK(plan_of("squeeze the cake").actions[0].magnitude == doctest::Approx(0.825));  // half of the way from each side
  CHECK(plan_of("press the cake from the left").actions[0].magnitude == doctest::Approx(0.65));
  CHECK(plan_of("spin the ball very hard").actions[0].magnitude == doctest::Approx(8));
  CHECK(plan_of("spin the ball violently and very fast").actions[0].magnitude <= 12);
  CHECK(plan_of("hold the ball").actions[0].magnitude == 0);
  CHECK(plan_of("hold the ball").corrections.empty());
  for (int i = 0; i < kActionCount; ++i) {
    const ActionLine& range = action_line(static_cast<ActionType>(i));
    CHECK(static_cast<int>(range.kind) == i);
    CHECK(range.min <= range.magnitude);
    CHECK(range.magnitude <= range.max);
  }
}

TEST_CASE("ground: what cannot be found is refused by name") {
  const std::string missing = refusal("push the piano");
  CHECK(missing.find("\"piano\"") != std::string::npos);
  CHECK(missing.find("cake/sponge") != std::string::npos);
  // Two parts are called a head: the message names the action and what it could have meant.
  const std::string which = refusal("push the head to the left");
  for (const char* text : {"\"push\"", "hammer/head", "sunflower/head"}) CHECK(which.find(text) != std::string::npos);
}

TEST_CASE("ground: strengths, speeds and times stay within bounds and are said") {
  CHECK(plan_of("press the cake").actions[0].magnitude == doctest::Approx(0.15));
  CHECK(plan_of("gently press the cake").actions[0].magnitude == doctest::Approx(0.075));
  CHECK(plan_of("press the cake very gently").actions[0].magnitude == doctest::Approx(0.0375));
  CHECK(plan_of("press the cake hard").actions[0].magnitude == doctest::Approx(0.3));
  CHECK(plan_of("push the ball at 2 m/s to the left").actions[0].magnitude == doctest::Approx(2));
  const Plan fast = plan_of("push the ball at 50 m/s to the left");
  CHECK(fast.actions[0].magnitude == doctest::Approx(3));
  CHECK(join(fast.corrections).find("50") != std::string::npos);
  const RunSpecification run;
  const Plan press = plan_of("press the cake");
  CHECK(press.actions[0].start == doctest::Approx(0.1));
  CHECK(press.actions[0].end == doctest::Approx(0.6 * run.time.duration()));
  const Plan timed = plan_of("after 0.5 seconds push the ball to the left for 0.25 s");
  CHECK(timed.actions[0].start == doctest::Approx(0.5));
  CHECK(timed.actions[0].end == doctest::Approx(0.75));
  CHECK(plan_of("push the ball to the left for 100 s").actions[0].end == doctest::Approx(run.time.duration()));
  const Plan kick = plan_of("kick the ball to the left");
  CHECK(kick.actions[0].end - kick.actions[0].start == doctest::Approx(4 * run.time.substep_dt));
  const Plan turn = plan_of("turn the ball by 90 degrees");
  CHECK(turn.actions[0].magnitude * (turn.actions[0].end - turn.actions[0].start) == doctest::Approx(1.5707963));
}

TEST_CASE("ground: a mover is driven over the gap and a quarter of the target's depth") {
  const Plan drop = plan_of("the hammer falls and hits the cake");
  // gap 1.5 - 0.25 - 0.25, depth 0.5, scale 0.25, speed 0.6
  CHECK(drop.actions[0].end - drop.actions[0].start == doctest::Approx(0.25 * (1.0 + 0.125) / 0.6));
}

TEST_CASE("ground: what was defaulted or not understood stands in the corrections") {
  CHECK(join(plan_of("push the ball").corrections).find("no direction") != std::string::npos);
  CHECK(join(plan_of("the guitar plays a song").corrections).find("not understood") != std::string::npos);
  CHECK(join(plan_of("the ball falls").corrections).find("gravity") != std::string::npos);
}

TEST_CASE("ground: words") {
  CHECK(singular("strawberries") == "strawberry");
  CHECK(singular("glass") == "glass");
  CHECK(singular("leaves") == "leaf");
  CHECK(singular("boxes") == "box");
  CHECK(identifier_of("  Left Leaf #2 ") == "left-leaf-2");
  CHECK(identifier_of("???") == "object");
  CHECK(tokens_of("The hammer's head, at 2.5 m/s") ==
        std::vector<std::string>{"the", "hammer", "head", ",", "at", "2.5", "m/s"});
}

TEST_CASE("ground: the inventory without an author comes from the prompt's noun") {
  const std::vector<std::pair<std::string, std::string>> kTable = {
      {"the guitar falls onto the floor", "guitar"},
      {"Press the cake", "cake"},
      {"an old acoustic guitar is dropped", "old-acoustic-guitar"},
      {"falls", "my-scan"},
      {"a hand presses the cake", "cake"},
      {"it falls", "my-scan"},
      {"the head of the statue is pushed to the left", "statue"},
      {"a hammer hits the figure", "figure"},
      {"a hammer falls", "hammer"},
      {"two hands stretch the dough", "dough"},
      {"A ficus in a pot: its leaves move in the wind", "ficus"},
      {"a rubber bear bouncing on a surface", "bear"},
      {"someone presses the object", "my-scan"},
      {"Der Ball faellt auf den Boden", "my-scan"}};
  for (const auto& entry : kTable) {
    const auto &prompt = entry.first, &id = entry.second;
    CAPTURE(prompt);
    Inventory inventory = inventory_from_prompt(prompt, "my-scan");
    CHECK(inventory.objects[0].id == id);
    complete_inventory(inventory, {"front", "right"}, "");
    REQUIRE(inventory.rows.size() == 2);
    CHECK_FALSE(inventory.rows[0].residual);
    CHECK(inventory.rows[1].key() == id + "/residual");
    CHECK(inventory.rows[1].residual);
    CHECK(inventory.objects[0].queries.size() == 2);
  }
}

TEST_CASE("ground: residual rows follow all semantic rows, in object order") {
  const Inventory inventory = workshop();
  REQUIRE(inventory.rows.size() == 16);
  for (int o = 0; o < 5; ++o) {
    CHECK(inventory.rows[11 + o].residual);
    CHECK(inventory.rows[11 + o].object == inventory.objects[o].id);
  }
  Inventory bad = inventory;
  bad.rows[0].part = "residual";
  CHECK_THROWS_AS(complete_inventory(bad, {}, "f"), Error);
}

TEST_CASE("ground: directions follow the up axis and the front camera") {
  for (const char* up : {"x", "y", "z", "-x", "-y", "-z"}) {
    CAPTURE(up);
    Scene scene;
    scene.run.placement.up = up;
    const Eigen::Vector3d u = axis_vector(up);
    const Eigen::Vector3d side = std::abs(u.z()) > 0.5 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    SceneView view;
    view.name = "front";
    view.camera = look_at(4 * side + 1.5 * u, Eigen::Vector3d::Zero(), u, 0.7, 64, 64);
    scene.views.push_back(view);
    const SceneGeometry g = measure_scene(scene, Inventory(), {});
    CHECK((g.up - u).norm() < 1e-12);
    CHECK((g.toward - side).norm() < 1e-9);
    // What lies to the right is to the right in the image, what lies down is lower.
    const Camera& camera = view.camera;
    const auto pixel = [&](const Eigen::Vector3d& p) { return camera.project(camera.to_camera(p)); };
    CHECK(pixel(0.5 * g.axis(DirectionWord::right)).x() > pixel(Eigen::Vector3d::Zero()).x() + 1);
    CHECK(pixel(0.5 * g.axis(DirectionWord::down)).y() > pixel(Eigen::Vector3d::Zero()).y() + 1);
    CHECK(pixel(0.5 * g.axis(DirectionWord::toward)).y() > pixel(Eigen::Vector3d::Zero()).y());
  }
}
