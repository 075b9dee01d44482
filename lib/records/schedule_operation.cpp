#include "records/schedule_operation.h"

#include <array>
#include <cmath>

#include "records/json.h"

namespace physmas {
namespace {

using Kind = ScheduleOperation::Kind;

enum Field : unsigned {
  kVelocity = 1,
  kDirection = 2,
  kSlab = 4,
  kRatio = 8,
  kRate = 16,
  kSpeedLimit = 32,
  kBlendTime = 64,
  kPositionWeight = 128,
  kFollow = 256,
  kNeighbours = 512,
  kProjection = 1024
};

struct KindLine {
  const char* name;
  unsigned fields;
};
constexpr std::array<KindLine, 12> kKinds = {
    {{"translation", kVelocity},
     {"top_press", kVelocity | kSlab},
     {"radial_spread", kSpeedLimit | kBlendTime | kPositionWeight},
     {"vertical_compress", kRatio | kSpeedLimit},
     {"side_compress", kDirection | kSlab | kRatio | kSpeedLimit | kBlendTime | kPositionWeight},
     {"drag_pair", kVelocity | kDirection | kSlab | kFollow | kNeighbours | kBlendTime},
     {"scale", kDirection | kSlab | kRatio | kSpeedLimit},
     {"impulse", kVelocity},
     {"torque", kDirection | kSlab | kRate | kSpeedLimit | kBlendTime},
     {"support_hold", kDirection | kSlab},
     {"structure_projection", kProjection},
     {"interface_retention", kNeighbours}}};

unsigned operation_fields(Kind kind) {
  return kKinds[static_cast<int>(kind)].fields;
}

}  // namespace

Json to_json(const ScheduleOperation& op) {
  const unsigned fields = operation_fields(op.kind);
  Json json;
  json["operation"] = kKinds[static_cast<int>(op.kind)].name;
  json["rows"] = op.rows;
  if (fields & kVelocity) json["velocity"] = to_json(op.velocity);
  if (fields & kDirection) json["direction"] = to_json(op.direction);
  if (op.is_action()) {
    json["start"] = op.start;
    json["end"] = op.end;
    json["start_step"] = op.start_step;
    json["end_step"] = op.end_step;
  }
  if (fields & kSlab) json["slab_fraction"] = op.slab_fraction;
  if (fields & kRatio) json["ratio"] = op.ratio;
  if (fields & kRate) json["rate"] = op.rate;
  if (fields & kSpeedLimit) json["speed_limit"] = op.speed_limit;
  if (fields & kBlendTime) json["blend_time"] = op.blend_time;
  if (fields & kPositionWeight) json["position_weight"] = op.position_weight;
  if (fields & kFollow) {
    json["follow"] = kFollowNames[static_cast<int>(op.follow)];
    json["distance"] = op.distance;
  }
  if (fields & kProjection) {
    json["eta"] = op.eta;
    json["mode"] = op.rigid ? "rigid" : "literal";
  }
  if (fields & kNeighbours) json["neighbours"] = op.neighbours;
  return json;
}

ScheduleOperation operation_from(const Json& json, const std::string& file, const std::string& pointer) {
  ScheduleOperation op;
  const std::string name = json.at("operation").get<std::string>();
  for (size_t i = 0; i < kKinds.size(); ++i) {
    if (name == kKinds[i].name) op.kind = static_cast<Kind>(i);
  }
  op.rows = json.at("rows").get<std::vector<int>>();
  const unsigned fields = operation_fields(op.kind);
  const auto need = [&](const char* field) -> const Json& {
    if (!json.contains(field))
      throw invalid_field(file, pointer, json, std::string("the field ") + field + " of " + name);
    return json.at(field);
  };
  if (fields & kVelocity) op.velocity = vector3_from(need("velocity"));
  if (fields & kDirection) {
    op.direction = vector3_from(need("direction"));
    if (std::abs(op.direction.norm() - 1) > 1e-6)
      throw invalid_field(file, pointer + "/direction", json.at("direction"), "a unit vector");
  }
  if (op.is_action()) {
    op.start = need("start").get<double>();
    op.end = need("end").get<double>();
    op.start_step = need("start_step").get<int>();
    op.end_step = need("end_step").get<int>();
    if (op.end < op.start) throw invalid_field(file, pointer + "/end", op.end, "a time at or after /start");
  }
  if (fields & kSlab) op.slab_fraction = need("slab_fraction").get<double>();
  if (fields & kRatio) op.ratio = need("ratio").get<double>();
  if (fields & kRate) op.rate = need("rate").get<double>();
  if (fields & kSpeedLimit) op.speed_limit = need("speed_limit").get<double>();
  if (fields & kBlendTime) op.blend_time = need("blend_time").get<double>();
  if (fields & kPositionWeight) op.position_weight = need("position_weight").get<double>();
  if (fields & kFollow) {
    op.follow = follow_from(need("follow").get<std::string>());
    op.distance = need("distance").get<double>();
  }
  if (fields & kProjection) {
    op.eta = need("eta").get<double>();
    op.rigid = json.value("mode", "literal") == "rigid";
  }
  if (fields & kNeighbours) op.neighbours = need("neighbours").get<std::vector<int>>();
  return op;
}

}  // namespace physmas
