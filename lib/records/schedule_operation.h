// One compiled operation of a candidate's schedule Gamma.
#ifndef PHYSMAS_RECORDS_SCHEDULE_OPERATION_H
#define PHYSMAS_RECORDS_SCHEDULE_OPERATION_H

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "records/actions.h"
#include "records/json_fwd.h"

namespace physmas {

// Fields that a kind does not use keep their defaults and are not written (operation_fields in actions.h tells which).
// Lengths, velocities and directions are in solver space.
struct ScheduleOperation {
  using Kind = OperationKind;
  Kind kind = Kind::translation;
  std::vector<int> rows;                                 // inventory row indices
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();    // m/s: enforced, or the change that an impulse gives
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // unit: axis, inward direction, or which end a slab is at
  double start = 0, end = 0;                             // seconds, [start, end)
  int start_step = 0, end_step = 0;                      // substeps, [start, end)
  double slab_fraction = 1;    // thickness of the slab over the rows' rest extent; 1: all of the rows
  double ratio = 1;            // final over rest extent
  double rate = 0;             // rad/s about `direction`
  double speed_limit = 1;      // m/s
  double blend_time = 2e-3;    // s
  double position_weight = 0;  // share of the field in the motion of places
  bool enforced = false;       // torque: not blended (run specification, controls.stiff)
  double strain_limit = 1;     // of an enforced torque: shear between its slab and the other end
  double release = 0;          // s after `end` in which a hand goes back; 0: it vanishes
  Follow follow = Follow::none;
  double distance = 0;          // m: how far the interface of drag_pair reaches
  std::vector<int> neighbours;  // drag_pair: rows that follow; interface_retention: rows that may be bonded
  double eta = 0;               // structure_projection
  bool rigid = false;           // structure_projection: turns with the row (run specification, projection.mode)
  bool is_action() const { return kind < Kind::structure_projection; }
};

// How a torque moves its particles; the names of ScheduleOperation::enforced, false and true.
inline constexpr std::array<const char*, 2> kDriveNames = {"blended", "enforced"};

// json: an entry of /schedule that its schema accepted. A field that the kind needs and that is missing, or a value
// that makes no sense, is an Error (exit code 3). file, pointer: where it stands.
ScheduleOperation operation_from(const Json& json, const std::string& file, const std::string& pointer);
Json to_json(const ScheduleOperation& operation);

// The properties of such an entry in schemas/candidate.json.
Json operation_schema();

}  // namespace physmas

#endif
