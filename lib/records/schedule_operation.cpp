#include "records/schedule_operation.h"

#include <cmath>

#include "records/fields.h"
#include "records/run_specification.h"

namespace physmas {
namespace {

// fields: which of them (OperationField). Bounds and descriptions are those of /schedule in schemas/candidate.json,
// which a test compares with operation_schema.
template <class Operation, class Visitor>
void visit_fields(Operation& op, unsigned fields, Visitor& visitor) {
  visitor.field("rows", op.rows, at_least(0, 1), "inventory row indices that it acts on");
  if (fields & kHasVelocity)
    visitor.field("velocity", op.velocity, kVec3,
                  "enforced velocity, or the velocity change of an impulse; solver space, m/s");
  if (fields & kHasDirection)
    visitor.field("direction", op.direction, kVec3,
                  "unit: axis of scale and torque, inward direction of side_compress, the end that a slab lies at");
  if (fields & kHasInterval) {
    visitor.field("start", op.start, kNotNegative, "seconds");
    visitor.field("end", op.end, kNotNegative, "seconds");
    visitor.field("start_step", op.start_step, at_least(0), "");
    visitor.field("end_step", op.end_step, at_least(0), "");
  }
  if (fields & kHasSlab)
    visitor.field("slab_fraction", op.slab_fraction, kUnit,
                  "thickness of the slab as a fraction of the rows' rest extent; 1: all of the rows");
  if (fields & kHasRatio) visitor.field("ratio", op.ratio, above(0, 100), "final over rest extent");
  if (fields & kHasRate) visitor.field("rate", op.rate, between(-1000, 1000), "torque: rad/s about direction");
  if (fields & kHasSpeedLimit)
    visitor.field("speed_limit", op.speed_limit, above(0, 1000),
                  "m/s; of radial_spread: the speed of the outermost particles");
  if (fields & kHasBlendTime)
    visitor.field("blend_time", op.blend_time, kPositive,
                  "seconds in which a blend takes away 63 % of a difference in velocity");
  if (fields & kHasPositionWeight)
    visitor.field("position_weight", op.position_weight, kUnit, "share of the field in the motion of places");
  if (fields & kHasDrive) {
    visitor.field("drive", choice(op.enforced, kDriveNames), {},
                  "torque: blended, a bounded force (default), or enforced where rows are too stiff for it");
    visitor.field(
        "strain_limit", op.strain_limit, kPositive,
        "of an enforced torque: largest angle x radius / length between the slabs; its rate is lowered to it");
  }
  if (fields & kHasRelease)
    visitor.field("release", op.release, kNotNegative,
                  "seconds after end in which the hand goes back to where it began and holds back what overtakes it; 0 "
                  "(default): it vanishes");
  if (fields & kHasFollow) {
    visitor.field("follow", choice(op.follow, kFollowNames), {},
                  "drag_pair: what of the neighbours follows the puller");
    visitor.field("distance", op.distance, kNotNegative,
                  "drag_pair: rest distance to the puller within which the interface follows, m of solver space");
  }
  if (fields & kHasProjection) {
    visitor.field("eta", op.eta, kUnit, "structure_projection");
    visitor.field("mode", choice(op.rigid, kProjectionModes), {},
                  "structure_projection: literal (default), or rigid: turned with the row");
  }
  if (fields & kHasNeighbours)
    visitor.field("neighbours", op.neighbours, at_least(0),
                  "drag_pair: rows that may follow; interface_retention: rows whose particles may be bonded");
}

// Fields that files of an earlier version do not have.
bool optional(const std::string& name) {
  return name == "mode" || name == "drive" || name == "strain_limit" || name == "release";
}

// A reader that needs every other field.
class OperationReader {
 public:
  OperationReader(const Json& json, const std::string& file, const std::string& pointer)
      : json_(json), file_(file), pointer_(pointer) {}
  template <class T>
  void field(const char* name, T&& value, const Rule&, const char*) {
    if (json_.contains(name)) {
      read_field(json_.at(name), value);
    } else if (!optional(name)) {
      throw invalid_field(file_, pointer_, json_,
                          std::string("the field ") + name + " of " + json_.at("operation").get<std::string>());
    }
  }

 private:
  const Json& json_;
  const std::string &file_, &pointer_;
};

}  // namespace

Json to_json(const ScheduleOperation& op) {
  Json json;
  FieldWriter writer(json);
  writer.field("operation", choice(op.kind, kOperationNames));
  visit_fields(op, operation_fields(op.kind), writer);
  return json;
}

ScheduleOperation operation_from(const Json& json, const std::string& file, const std::string& pointer) {
  ScheduleOperation op;
  OperationReader reader(json, file, pointer);
  reader.field("operation", choice(op.kind, kOperationNames), {}, "");
  visit_fields(op, operation_fields(op.kind), reader);
  if (std::abs(op.direction.norm() - 1) > 1e-6)
    throw invalid_field(file, pointer + "/direction", json.at("direction"), "a unit vector");
  if (op.end < op.start) throw invalid_field(file, pointer + "/end", op.end, "a time at or after /start");
  return op;
}

Json operation_schema() {
  ScheduleOperation op;
  FieldSchema schema;
  schema.field("operation", choice(op.kind, kOperationNames), {}, "");
  visit_fields(op, kHasEverything, schema);
  return schema.take();
}

}  // namespace physmas
