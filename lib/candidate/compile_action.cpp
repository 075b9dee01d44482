#include "candidate/compile_action.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "candidate/stiff_rows.h"

namespace physmas::candidate {
namespace {

// The paper bounds its actions without printing the numbers; these are ours (docs/actions.md says why).
constexpr double kSlabFraction = 0.2;         // thickness of every slab over the rows' extent
constexpr double kCompressSpeed = 0.5;        // m/s, vertical_compress and side_compress
constexpr double kScaleSpeed = 1;             // m/s
constexpr double kTorqueSpeed = 1.5;          // m/s
constexpr double kBlendTime = 2e-3;           // s
constexpr double kSqueezeTime = 5e-4;         // s, side_compress
constexpr double kPositionWeight = 0.1;       // radial_spread, side_compress
constexpr double kRelease = 0.25;             // s
constexpr double kStrainLimit = 1;            // of an enforced torque
constexpr double kInterfaceDistance = 0.045;  // m, as d_b of the interface retention

using Rows = std::vector<ActiveRow>;

std::vector<int> indices(const Rows& rows) {
  std::vector<int> list;
  for (const ActiveRow& a : rows) list.push_back(a.row);
  return list;
}

// The rows of the given support value; all of them when there are none.
Rows with_support(const Rows& rows, bool support) {
  Rows found;
  for (const ActiveRow& a : rows) {
    if (a.support == support) found.push_back(a);
  }
  return found.empty() ? rows : found;
}

class ActionCompiler {
 public:
  ActionCompiler(const Context& context, const PlanAction& action, const std::string& file, const std::string& pointer)
      : context_(context), action_(action), file_(file), pointer_(pointer) {}

  ScheduleOperation compile() {
    op_.kind = action_.type;
    op_.start = action_.start;
    op_.end = std::min(action_.end, context_.run.time.duration());
    op_.direction = action_.direction;
    if (!context_.run.controls.literal_release) op_.release = kRelease;
    const bool has_source = !action_.source.empty();
    const Rows rows = has_source ? active_rows(action_.source, "/source") : active_rows(action_.target, "/target");
    op_.rows = indices(rows);
    switch (action_.type) {
      case ActionType::translation:
        op_.velocity = action_.magnitude * action_.direction;
        break;
      case ActionType::top_press:
        op_.velocity = action_.magnitude * action_.direction;
        op_.slab_fraction = kSlabFraction;
        break;
      case ActionType::impulse:
        op_.velocity = action_.magnitude * action_.direction;
        op_.end = std::min(op_.end, op_.start + kImpulseSubsteps * context_.run.time.substep_dt);
        break;
      case ActionType::radial_spread:
        op_.rows = indices(with_support(rows, false));
        op_.speed_limit = positive("a speed above 0");
        op_.blend_time = kBlendTime;
        op_.position_weight = kPositionWeight;
        break;
      case ActionType::vertical_compress:
        op_.rows = indices(with_support(rows, false));
        op_.ratio = compression_ratio();
        op_.speed_limit = kCompressSpeed;
        break;
      case ActionType::side_compress:
        op_.ratio = compression_ratio();
        op_.slab_fraction = kSlabFraction;
        op_.speed_limit = kCompressSpeed;
        op_.blend_time = kSqueezeTime;
        op_.position_weight = kPositionWeight;
        break;
      case ActionType::drag_pair:
        op_.velocity = action_.magnitude * action_.direction;
        op_.slab_fraction = has_source ? 1 : kSlabFraction;
        op_.blend_time = kBlendTime;
        op_.follow = action_.follow;
        op_.distance = kInterfaceDistance;
        if (op_.follow != Follow::none) op_.neighbours = indices(active_rows(action_.target, "/target"));
        break;
      case ActionType::scale:
        op_.ratio = positive("a ratio above 0");
        op_.slab_fraction = kSlabFraction;
        op_.speed_limit = kScaleSpeed;
        break;
      case ActionType::torque:
        compile_torque();
        break;
      case ActionType::support_hold:
        compile_hold(rows);
        break;
      default:
        throw internal_error("a plan with an operation that is no action");
    }
    return op_;
  }

 private:
  Rows active_rows(const std::string& reference, const char* field) const {
    const std::vector<int> rows = resolve_rows(context_.inventory, reference);
    Rows found;
    for (const ActiveRow& a : context_.active) {
      if (std::find(rows.begin(), rows.end(), a.row) != rows.end()) found.push_back(a);
    }
    if (found.empty()) {
      throw invalid_input({file_, pointer_ + field, "\"" + reference + "\", which has no active row",
                           "an object or a row with Gaussians"});
    }
    return found;
  }

  double positive(const char* expected) const {
    if (!(action_.magnitude > 0)) throw wrong_magnitude(expected);
    return action_.magnitude;
  }

  double compression_ratio() const {
    if (!(action_.magnitude > 0 && action_.magnitude <= 1)) throw wrong_magnitude("a ratio above 0, at most 1");
    return action_.magnitude;
  }

  Error wrong_magnitude(const char* expected) const {
    return invalid_input({file_, pointer_ + "/magnitude", fmt::format("{}", action_.magnitude), expected});
  }

  // A slab is at the upper end whichever way it is turned.
  void compile_torque() {
    const bool down = action_.direction.dot(context_.run.placement.up_vector()) < -1e-9;
    op_.direction = down ? Eigen::Vector3d(-action_.direction + Eigen::Vector3d::Zero()) : action_.direction;
    op_.rate = down ? -action_.magnitude : action_.magnitude;
    op_.slab_fraction = action_.slab ? kSlabFraction : 1;
    op_.speed_limit = kTorqueSpeed;
    op_.blend_time = kBlendTime;
    op_.strain_limit = kStrainLimit;
    // What turns freely goes on turning.
    if (!is_attached(context_, op_)) op_.release = 0;
  }

  // Eligible are a row that was named, the supports of an object, and without supports its slab at `direction`.
  void compile_hold(const Rows& rows) {
    op_.slab_fraction = 1;
    if (action_.slab) {
      op_.slab_fraction = kSlabFraction;
      return;
    }
    const Rows supports = with_support(rows, true);
    const bool whole_row = action_.target.find('/') != std::string::npos;
    if (whole_row) return;
    if (supports.front().support) {
      op_.rows = indices(supports);
    } else {
      op_.slab_fraction = kSlabFraction;
    }
  }

  const Context& context_;
  const PlanAction& action_;
  const std::string& file_;
  const std::string& pointer_;
  ScheduleOperation op_;
};

}  // namespace

ScheduleOperation compile_action(const Context& context, const PlanAction& action, const std::string& plan_file,
                                 const std::string& pointer) {
  return ActionCompiler(context, action, plan_file, pointer).compile();
}

}  // namespace physmas::candidate
