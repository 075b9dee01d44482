// The actions, each once: name, what moves, bounds of its magnitude, when it acts by default, and which fields its
// compiled operation has. Plans, schedules and the agents' vocabulary stem from this table.
#ifndef PHYSMAS_RECORDS_ACTIONS_H
#define PHYSMAS_RECORDS_ACTIONS_H

#include <array>
#include <string>

namespace physmas {

// What a schedule is made of: the supported actions (paper, Table "actions"), in the paper's order, and then the
// operations at output frames, which no plan asks for.
enum class OperationKind : int {
  translation = 0,
  top_press,
  radial_spread,
  vertical_compress,
  side_compress,
  drag_pair,
  scale,
  impulse,
  torque,
  support_hold,
  structure_projection,
  interface_retention
};
constexpr int kActionCount = 10, kOperationCount = 12;
using ActionType = OperationKind;  // one of the first ten

// Fields of a compiled operation beside its rows (schedule_operation.h).
enum OperationField : unsigned {
  kHasVelocity = 1,
  kHasDirection = 2,
  kHasInterval = 4,
  kHasSlab = 8,
  kHasRatio = 16,
  kHasRate = 32,
  kHasSpeedLimit = 64,
  kHasBlendTime = 128,
  kHasPositionWeight = 256,
  kHasFollow = 512,
  kHasProjection = 1024,
  kHasNeighbours = 2048,
  kHasRelease = 4096,
  kHasDrive = 8192,
  kHasEverything = 16383
};

struct ActionLine {
  OperationKind kind;
  const char* name;
  unsigned fields;   // of its operation
  bool moved;        // by a source, where a plan names one; the others change the target itself
  const char* unit;  // of the magnitude, for messages; empty: it is the ratio of the final to the rest extent
  // In solver space. The paper bounds magnitudes without printing the bounds: these are ours (docs/actions.md).
  double magnitude, min, max;
  double start;         // s, by default
  double end_fraction;  // of the run's duration, by default
};

inline constexpr std::array<ActionLine, kActionCount> kActions = {{
    {ActionType::translation, "translation", kHasVelocity | kHasInterval, true, " m/s", 0.6, 0.05, 3, 0, 0.5},
    {ActionType::top_press, "top_press", kHasVelocity | kHasInterval | kHasSlab | kHasRelease, true, " m/s", 0.15, 0.02,
     0.6, 0.1, 0.6},
    {ActionType::radial_spread, "radial_spread", kHasInterval | kHasSpeedLimit | kHasBlendTime | kHasPositionWeight,
     false, " m/s", 0.3, 0.05, 1.5, 0.1, 0.6},
    {ActionType::vertical_compress, "vertical_compress", kHasInterval | kHasRatio | kHasSpeedLimit | kHasRelease, false,
     "", 0.6, 0.2, 1, 0.1, 0.6},
    {ActionType::side_compress, "side_compress",
     kHasDirection | kHasInterval | kHasSlab | kHasRatio | kHasSpeedLimit | kHasBlendTime | kHasPositionWeight |
         kHasRelease,
     true, "", 0.65, 0.2, 1, 0.1, 0.6},
    {ActionType::drag_pair, "drag_pair",
     kHasVelocity | kHasDirection | kHasInterval | kHasSlab | kHasBlendTime | kHasFollow | kHasNeighbours, true, " m/s",
     0.4, 0.05, 2, 0, 0.5},
    {ActionType::scale, "scale", kHasDirection | kHasInterval | kHasSlab | kHasRatio | kHasSpeedLimit | kHasRelease,
     false, "", 1.5, 0.3, 3, 0.1, 0.6},
    {ActionType::impulse, "impulse", kHasVelocity | kHasInterval, true, " m/s", 1.5, 0.1, 6, 0.1, 0},
    {ActionType::torque, "torque",
     kHasDirection | kHasInterval | kHasSlab | kHasRate | kHasSpeedLimit | kHasBlendTime | kHasDrive | kHasRelease,
     false, " rad/s", 2, 0.2, 12, 0.1, 0.6},
    {ActionType::support_hold, "support_hold", kHasDirection | kHasInterval | kHasSlab, false, " m/s", 0, 0, 0, 0, 1},
}};

// Impulses are "capped at four base substeps" (paper, Table "actions").
constexpr int kImpulseSubsteps = 4;

inline constexpr const ActionLine& action_line(ActionType type) {
  return kActions[static_cast<size_t>(type)];
}
inline constexpr const char* action_name(ActionType type) {
  return action_line(type).name;
}
// Whether the magnitude is a ratio of extents, so that a strength scales its distance from 1.
inline constexpr bool is_ratio(ActionType type) {
  return *action_line(type).unit == '\0';
}

inline constexpr std::array<const char*, kOperationCount> kOperationNames = [] {
  std::array<const char*, kOperationCount> names = {};
  for (size_t i = 0; i < kActions.size(); ++i) names[i] = kActions[i].name;
  names[kActionCount] = "structure_projection";
  names[kActionCount + 1] = "interface_retention";
  return names;
}();
inline constexpr unsigned operation_fields(OperationKind kind) {
  if (kind == OperationKind::structure_projection) return kHasProjection;
  return kind == OperationKind::interface_retention ? kHasNeighbours : action_line(kind).fields;
}

// name: of an action; another one, which a schema should have refused, is an internal Error.
ActionType action_from(const std::string& name);

// Which particles of a target follow the puller of a drag_pair: none, those near it at rest, or all.
enum class Follow : int { none = 0, interface, target };
inline constexpr std::array<const char*, 3> kFollowNames = {"none", "interface", "target"};

}  // namespace physmas

#endif
