// The table of actions and what stems from it: operations of a schedule, their schema, and the names in schemas.
#include "records/actions.h"

#include <doctest/doctest.h>

#include "records/json.h"
#include "records/schedule_operation.h"
#include "records/validator.h"
#include "unit/input_error.h"

using namespace physmas;

namespace {

// An operation in which no two fields have the same value, nor one its default.
ScheduleOperation operation(OperationKind kind) {
  ScheduleOperation op;
  op.kind = kind;
  op.rows = {2, 4};
  op.velocity = {0.1, -0.2, 0.3};
  op.direction = {0.6, 0, -0.8};
  op.start = 0.25, op.end = 0.75;
  op.start_step = 5, op.end_step = 7;
  op.slab_fraction = 0.15;
  op.ratio = 0.65;
  op.rate = -2.5;
  op.speed_limit = 0.45;
  op.blend_time = 3e-3;
  op.position_weight = 0.11;
  op.enforced = true;
  op.strain_limit = 0.7;
  op.release = 0.35;
  op.follow = Follow::target;
  op.distance = 0.07;
  op.neighbours = {1, 3};
  op.eta = 0.85;
  op.rigid = true;
  return op;
}

}  // namespace

TEST_CASE("actions: schemas have the names of the table") {
  Json names = Json::array();
  for (const ActionLine& action : kActions) names.push_back(action.name);
  for (const char* schema : {"plan", "scene_reply"}) {
    const Json::json_pointer type("/properties/actions/items/properties/type/enum");
    CHECK(schema_document(schema).at(type) == names);
  }
}

TEST_CASE("actions: bounds hold the defaults, and ratios and intervals make sense") {
  for (const ActionLine& action : kActions) {
    CAPTURE(action.name);
    CHECK(action_from(action.name) == action.kind);
    CHECK(action.min <= action.magnitude);
    CHECK(action.magnitude <= action.max);
    CHECK((action.end_fraction >= 0 && action.end_fraction <= 1));
    CHECK(is_ratio(action.kind) == ((action.fields & kHasRatio) != 0));
  }
  CHECK_THROWS_AS(action_from("structure_projection"), Error);
}

TEST_CASE("actions: schemas/candidate.json has the fields of an operation") {
  const Json::json_pointer schedule("/properties/schedule/items/properties");
  const Json expected = operation_schema(), found = schema_document("candidate").at(schedule);
  // Without regard to the order.
  CHECK(nlohmann::json(found) == nlohmann::json(expected));
}

TEST_CASE("actions: an operation keeps the fields of its kind, and needs each of them") {
  for (int i = 0; i < kOperationCount; ++i) {
    const OperationKind kind = static_cast<OperationKind>(i);
    CAPTURE(kOperationNames[i]);
    const Json json = to_json(operation(kind));
    CHECK(json.at("operation") == kOperationNames[i]);
    CHECK(to_json(operation_from(json, "c.json", "/schedule/0")) == json);
    for (const auto& [name, value] : json.items()) {
      if (name == "operation" || name == "mode" || name == "drive" || name == "strain_limit" || name == "release")
        continue;
      Json lacking = json;
      lacking.erase(name);
      const std::string wanted = "the field " + name + " of " + kOperationNames[i];
      const std::string message = message_of([&, &json = lacking] { operation_from(json, "c.json", "/schedule/0"); });
      CHECK(message.find("c.json: /schedule/0: found") != std::string::npos);
      CHECK(message.find(wanted) != std::string::npos);
    }
  }
  // What a field of each kind is for, once.
  const Json drag = to_json(operation(OperationKind::drag_pair));
  CHECK(drag.at("follow") == "target");
  CHECK(drag.at("neighbours") == Json({1, 3}));
  CHECK_FALSE(drag.contains("ratio"));
  CHECK_FALSE(to_json(operation(OperationKind::interface_retention)).contains("start"));
  Json projection = to_json(operation(OperationKind::structure_projection));
  CHECK(operation_from(projection, "c.json", "").rigid);
  projection.erase("mode");
  CHECK_FALSE(operation_from(projection, "c.json", "").rigid);
  // A candidate of an earlier version acts as it did then.
  Json torque = to_json(operation(OperationKind::torque));
  for (const char* name : {"drive", "strain_limit", "release"}) torque.erase(name);
  const ScheduleOperation earlier = operation_from(torque, "c.json", "");
  CHECK_FALSE(earlier.enforced);
  CHECK(earlier.release == 0);
}

TEST_CASE("actions: an operation that makes no sense is refused by its field") {
  const auto refused = [](ScheduleOperation op) {
    return message_of([&] { operation_from(to_json(op), "c.json", "/schedule/3"); });
  };
  ScheduleOperation op = operation(OperationKind::torque);
  op.direction = {0.6, 0, 0.9};
  CHECK(refused(op).find("c.json: /schedule/3/direction") != std::string::npos);
  op = operation(OperationKind::torque);
  op.end = 0.2;
  CHECK(refused(op).find("c.json: /schedule/3/end: found 0.2") != std::string::npos);
}
