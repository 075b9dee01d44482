#include "bind/schedule.h"

#include <limits>

#include "bind/vector.h"

namespace physmas::bind {
namespace {

using Kind = ScheduleOperation::Kind;

void bind_drag(const ScheduleOperation& op, mpm::Schedule& schedule) {
  schedule.actions.push_back(
      mpm::SlabMotion{op.rows, to_mpm(op.velocity), to_mpm(op.direction), op.slab_fraction, op.start, op.end});
  if (op.follow == Follow::none) return;
  const double distance = op.follow == Follow::target ? std::numeric_limits<double>::infinity() : op.distance;
  schedule.actions.push_back(
      mpm::DragFollow{op.neighbours, op.rows, to_mpm(op.velocity), distance, op.blend_time, op.start, op.end});
}

}  // namespace

mpm::Torque bind_torque(const ScheduleOperation& op) {
  mpm::Torque torque;
  torque.rows = op.rows;
  torque.axis = to_mpm(op.direction);
  torque.rate = op.rate;
  torque.slab_fraction = op.slab_fraction;
  torque.speed_limit = op.speed_limit;
  torque.blend_time = op.blend_time;
  torque.enforced = op.enforced;
  if (op.enforced) torque.strain_limit = op.strain_limit;
  torque.start = op.start;
  torque.end = op.end;
  torque.release = op.release;
  return torque;
}

mpm::Schedule bind_schedule(const Candidate& candidate, const RunSpecification& run) {
  mpm::Schedule schedule;
  const mpm::Vec3d up = to_mpm(run.placement.up_vector());
  for (const ScheduleOperation& op : candidate.schedule) {
    const mpm::Vec3d velocity = to_mpm(op.velocity), direction = to_mpm(op.direction);
    switch (op.kind) {
      case Kind::translation:
        schedule.actions.push_back(mpm::Translation{op.rows, velocity, op.start, op.end});
        break;
      case Kind::top_press:
        schedule.actions.push_back(
            mpm::TopPress{op.rows, velocity, up, op.slab_fraction, op.start, op.end, op.release});
        break;
      case Kind::radial_spread:
        schedule.actions.push_back(
            mpm::RadialSpread{op.rows, up, op.speed_limit, op.blend_time, op.position_weight, op.start, op.end});
        break;
      case Kind::vertical_compress:
        schedule.actions.push_back(
            mpm::VerticalCompress{op.rows, up, op.ratio, op.speed_limit, op.start, op.end, op.release});
        break;
      case Kind::side_compress:
        schedule.actions.push_back(mpm::SideCompress{op.rows, direction, op.ratio, op.slab_fraction, op.speed_limit,
                                                     op.blend_time, op.position_weight, op.start, op.end, op.release});
        break;
      case Kind::drag_pair:
        bind_drag(op, schedule);
        break;
      case Kind::scale:
        for (const mpm::Vec3d& side : {direction, -direction}) {
          schedule.actions.push_back(
              mpm::ScaleSlab{op.rows, side, op.ratio, op.slab_fraction, op.speed_limit, op.start, op.end, op.release});
        }
        break;
      case Kind::impulse:
        schedule.actions.push_back(mpm::Impulse{op.rows, velocity, op.start, op.end - op.start, run.time.substep_dt});
        break;
      case Kind::torque:
        schedule.actions.push_back(bind_torque(op));
        break;
      case Kind::support_hold:
        schedule.actions.push_back(mpm::SlabMotion{op.rows, {0, 0, 0}, direction, op.slab_fraction, op.start, op.end});
        break;
      case Kind::structure_projection:
        for (const int row : op.rows) {
          using Mode = mpm::StructureProjection::Mode;
          schedule.projections.push_back({row, op.eta, op.rigid ? Mode::rigid : Mode::literal});
        }
        break;
      case Kind::interface_retention:
        for (const int row : op.rows) {
          mpm::InterfaceRetention retention;
          retention.support = row;
          retention.rows = op.neighbours;
          schedule.retentions.push_back(retention);
        }
        break;
    }
  }
  return schedule;
}

}  // namespace physmas::bind
