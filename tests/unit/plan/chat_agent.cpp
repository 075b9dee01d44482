#include "plan/chat_agent.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "plan/action_proposal.h"
#include "plan/scene_inventory.h"
#include "records/json.h"
#include "records/validator.h"
#include "unit/plan/scenes.h"

using namespace physmas;
using namespace physmas::plan;

namespace {

Json answer() {
  return parse_json(R"({
    "objects": [{"id": "cake", "name": "strawberry cake", "scene_role": ""},
                {"id": "ball", "name": "ball", "scene_role": ""}],
    "rows": [{"object": "cake", "part": "sponge", "name": "sponge", "structural_role": "", "physics_group": "", "expected_labels": ["Foam"]},
             {"object": "ball", "part": "ball", "name": "ball", "structural_role": "", "physics_group": "", "expected_labels": []}],
    "actions": [{"type": "translation", "source": "ball", "target": "cake", "role": "target", "direction": "toward cake",
                 "magnitude": 1, "start": null, "end": null}]})",
                    "test");
}

Inventory inventory() {
  Inventory i = inventory_from_answer(answer());
  complete_inventory(i, {"front"}, "test");
  return i;
}

SceneGeometry geometry() {
  return cubes_at({{"ball", {0, 0, 2}}, {"cake", {0, 0, 0}}}, 1);
}

Plan compile(const Json& changes) {
  Json proposal = answer();
  proposal["actions"][0].merge_patch(changes);
  // merge_patch drops nulls; the fields stay required.
  for (const char* field : {"source", "direction", "magnitude", "start", "end"}) {
    if (!proposal["actions"][0].contains(field)) proposal["actions"][0][field] = Json();
  }
  CHECK(find_schema_violations(proposal, "scene_reply").empty());
  return compile_proposal(proposal, "prompt", inventory(), geometry(), RunSpecification());
}

std::string refusal(const Json& changes) {
  try {
    compile(changes);
  } catch (const Error& e) {
    CHECK(e.code() == ExitCode::provider_failed);
    return e.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("ground: an agent's action becomes canonical, and every change is said") {
  Plan plan = compile(Json::object());
  const PlanAction& a = plan.actions.at(0);
  CHECK(a.source == "ball");
  CHECK(a.impact);
  // From the ball down to the cake.
  CHECK((a.direction - Eigen::Vector3d(0, 0, -1)).norm() < 1e-12);
  CHECK(plan.corrections.empty());
  CHECK(compile({{"direction", "to the left"}}).actions[0].direction.x() == -1);
  CHECK(compile({{"direction", "from above"}}).actions[0].direction.z() == -1);
  CHECK(compile({{"direction", "+y"}}).actions[0].direction.y() == 1);
  CHECK((compile({{"direction", {3, 0, 4}}}).actions[0].direction - Eigen::Vector3d(0.6, 0, 0.8)).norm() < 1e-12);
  CHECK(compile({{"direction", nullptr}}).actions[0].direction.z() == -1);
  plan = compile({{"target", "the strawberry cake"}, {"magnitude", 50}, {"end", 1000}});
  CHECK(plan.actions[0].target == "cake");
  CHECK(plan.actions[0].magnitude == 3);
  CHECK(plan.actions[0].end == doctest::Approx(RunSpecification().time.duration()));
  CHECK(plan.corrections.size() == 3);
  // A press goes down whatever the agent says.
  plan = compile({{"type", "top_press"}, {"source", nullptr}, {"direction", "left"}});
  CHECK(plan.actions[0].direction.z() == -1);
  CHECK(plan.corrections.size() >= 1);
}

TEST_CASE("ground: all ten actions compile from defaults") {
  for (const ActionLine& action : kActions) {
    const char* const name = action.name;
    CAPTURE(name);
    const bool hold = name == std::string("support_hold");
    const Plan plan = compile({{"type", name},
                               {"source", nullptr},
                               {"direction", nullptr},
                               {"magnitude", nullptr},
                               {"role", hold ? "support" : "target"}});
    CHECK(plan.actions[0].direction.norm() == doctest::Approx(1));
    CHECK(plan.actions[0].end > plan.actions[0].start);
  }
}

TEST_CASE("ground: an action that does not resolve names itself and the candidates") {
  CHECK(contains(refusal({{"target", "piano"}}), "/actions/0 (translation)"));
  CHECK(contains(refusal({{"target", "piano"}}), "cake/sponge"));
  CHECK(contains(refusal({{"target", "ball"}}), "source"));
  CHECK(contains(refusal({{"type", "torque"}}), "changes the target itself"));
  CHECK(contains(refusal({{"role", "support"}}), "support_hold"));
  CHECK(contains(refusal({{"direction", "sdrawkcab"}}), "three numbers"));
  CHECK(contains(refusal({{"direction", {0, 0, 0}}}), "not zero"));
  CHECK(contains(refusal({{"start", 100}}), "before the run's end"));
  CHECK(contains(refusal({{"start", 0.5}, {"end", 0.25}}), "after start"));
}

TEST_CASE("ground: inventories and queries that break the contract are rejected with the reason") {
  const Inventory registered = inventory();
  CHECK(inventory_rejection(answer(), &registered).empty());
  Json json = answer();
  json["rows"].push_back(json["rows"][0]);
  CHECK(contains(inventory_rejection(json, nullptr), "cake/sponge\" twice"));
  json = answer();
  json["rows"][0]["part"] = "residual";
  CHECK(contains(inventory_rejection(json, nullptr), "reserved"));
  json = answer();
  json["rows"][0]["part"] = "icing";
  CHECK(inventory_rejection(json, nullptr).empty());
  CHECK(contains(inventory_rejection(json, &registered), "cake/icing"));
  json = answer();
  json["rows"].erase(1);
  CHECK(contains(inventory_rejection(json, nullptr), "no part of \"ball\""));
  // Constitutive parameters and numeric settings are no part of the answer.
  for (const char* field : {"E", "density", "substep_dt"}) {
    json = answer();
    json["rows"][0][field] = 1;
    CHECK(!find_schema_violations(json, "scene_reply").empty());
  }
  json = answer();
  json["actions"][0]["type"] = "explode";
  CHECK(!find_schema_violations(json, "scene_reply").empty());

  const Json query = {{"key", "cake"}, {"text", "cake"}, {"visible_views", {"front"}}, {"colors", Json::array()}};
  Json queries;
  queries["queries"] = Json::array({query});
  CHECK(find_schema_violations(queries, "perception_reply").empty());
  CHECK(query_rejection(queries, {"cake"}, {"front"}).empty());
  CHECK(contains(query_rejection(queries, {"ball"}, {"front"}), "not asked about"));
  CHECK(contains(query_rejection(queries, {"cake", "ball"}, {"front"}), "no \"ball\""));
  CHECK(contains(query_rejection(queries, {"cake"}, {"back"}), "expected back"));
  queries["queries"].push_back(query);
  CHECK(contains(query_rejection(queries, {"cake"}, {"front"}), "twice"));
}
