#include "candidate/stiff_rows.h"

#include <algorithm>
#include <set>
#include <string>

namespace physmas::candidate {
namespace {

constexpr double kReach = 0.2 * 0.6;  // h l over the squared extent: a slab, and what lies between two of them

std::set<std::string> objects_of(const Context& context, const ScheduleOperation& op) {
  std::set<std::string> objects;
  for (const int row : op.rows) objects.insert(context.inventory.rows[row].object);
  return objects;
}

}  // namespace

bool is_attached(const Context& context, const ScheduleOperation& torque) {
  if (torque.slab_fraction < 1) return true;
  const std::set<std::string> objects = objects_of(context, torque);
  return std::any_of(context.active.begin(), context.active.end(), [&](const ActiveRow& a) {
    const bool turned = std::find(torque.rows.begin(), torque.rows.end(), a.row) != torque.rows.end();
    return !turned && objects.count(context.inventory_row(a).object) > 0;
  });
}

bool resists_blending(const Context& context, const std::vector<CandidateRow>& rows, const ScheduleOperation& torque) {
  if (!is_attached(context, torque)) return false;
  const std::set<std::string> objects = objects_of(context, torque);
  double squared_speed = 0;
  for (const CandidateRow& row : rows) {
    if (objects.count(context.inventory.rows[row.row].object) > 0)
      squared_speed = std::max(squared_speed, row.E / (2 * (1 + row.nu) * row.rho));
  }
  const double extent = context.run.placement.extent;
  return squared_speed * torque.blend_time * (torque.end - torque.start) > kReach * extent * extent;
}

}  // namespace physmas::candidate
