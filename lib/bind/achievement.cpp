#include "bind/achievement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/constants.h"
#include "bind/schedule.h"
#include "bind/vector.h"
#include "mpm/action/region_motion.h"
#include "records/labels.h"

namespace physmas::bind {
namespace {

using mpm::Places;
using mpm::Vec3d;
using Kind = ScheduleOperation::Kind;

constexpr double kMet = 0.8;         // a smaller share is said
constexpr double kDriftShare = 0.1;  // of the scene's longest side: all stillness is lost

Vec3d unit(const Vec3d& v) {
  const double length = norm(v);
  return length > 0 ? (1 / length) * v : Vec3d{0, 0, 0};
}

bool share_rows(const ScheduleOperation& a, const ScheduleOperation& b) {
  return std::any_of(a.rows.begin(), a.rows.end(),
                     [&](int row) { return std::find(b.rows.begin(), b.rows.end(), row) != b.rows.end(); });
}

// Two hands squeeze: each goes its part of the way, and the whole of it is asked of both.
double squeezed_ratio(const ScheduleOperation& op, const std::vector<ScheduleOperation>& schedule) {
  double ratio = 1;
  for (const ScheduleOperation& other : schedule) {
    const bool together = other.kind == op.kind && share_rows(op, other) && other.start < op.end &&
                          op.start < other.end && std::abs(other.direction.dot(op.direction)) > 0.99;
    if (together) ratio -= 1 - other.ratio;
  }
  return std::max(0.0, ratio);
}

const char* quantity_of(Kind kind) {
  switch (kind) {
    case Kind::torque:
      return "angle";
    case Kind::impulse:
      return "speed";
    case Kind::radial_spread:
      return "spread";
    case Kind::support_hold:
      return "drift";
    case Kind::vertical_compress:
    case Kind::side_compress:
    case Kind::scale:
      return "ratio";
    default:
      return "displacement";
  }
}

const char* unit_of(const std::string& quantity) {
  if (quantity == "angle") return "rad";
  if (quantity == "speed") return "m/s";
  return quantity == "displacement" || quantity == "drift" ? "m" : "";
}

// "Metal of 7e+07 Pa": the stiffest of the rows.
std::string stiffest(const std::vector<int>& rows, const Candidate& candidate) {
  const CandidateRow* found = nullptr;
  for (const CandidateRow& row : candidate.rows) {
    const bool meant = std::find(rows.begin(), rows.end(), row.row) != rows.end();
    if (meant && (found == nullptr || row.E > found->E)) found = &row;
  }
  return found == nullptr ? ""
                          : fmt::format("{} of {:.2g} Pa", kBranchNames[static_cast<int>(found->branch)], found->E);
}

}  // namespace

double longest_side(const std::vector<Vec3d>& places) {
  double longest = 0;
  for (int a = 0; a < 3; ++a) {
    const auto [low, high] =
        std::minmax_element(places.begin(), places.end(), [a](const Vec3d& x, const Vec3d& y) { return x[a] < y[a]; });
    longest = std::max(longest, (*high)[a] - (*low)[a]);
  }
  return longest;
}

double stillness_share(double drift, double longest_side) {
  return std::clamp(1 - drift / (kDriftShare * longest_side), 0.0, 1.0);
}

std::string shortfall_line(const AchievedAction& a) {
  const double scale = a.quantity == "angle" ? 180 / kPi : 1;
  const std::string unit = a.quantity == "angle" ? "degrees" : a.unit;
  return fmt::format("{} of {}: {} {:.3g} of {:.3g}{}: {}", action_name(a.type), fmt::join(a.rows, ", "), a.quantity,
                     scale * a.achieved, scale * a.requested, unit.empty() ? "" : " " + unit, a.shortfall);
}

// One action of the schedule.
struct AchievementMeter::Meter {
  Meter(const ScheduleOperation& operation, const Candidate& candidate, const mpm::Problem& problem, const Vec3d& up,
        double frame);
  void observe(const mpm::Frame& frame);
  AchievedAction result() const;

  const ScheduleOperation op;
  const double frame_dt, longest;  // s; m, of the scene
  const std::string quantity, material;
  const Vec3d gravity;
  Vec3d axis;                           // unit: what is measured lies along it or about it
  std::vector<int> rows;                // measured
  std::vector<int> particles, far_end;  // of them; far_end: the slab opposite, where two ends are compared
  double extent = 0;                    // m, of the rows along the axis at rest
  double requested = 0;                 // in the unit of the quantity
  double reachable = 0;                 // of that, at the speed that the action allows itself

  Places start, far_start, before;                       // at the start of the interval; at the frame before
  Vec3d velocity = {0, 0, 0}, acceleration = {0, 0, 0};  // of the mean at the last frame before the start
  double last_frame = 0;                                 // s: when that was
  double turned = 0;                                     // rad since the start
  bool began = false, moved = false, ended = false;
  double achieved = 0;

 private:
  mpm::Region choose(const mpm::Particles& rest, const Vec3d& up);
  void ask(const std::vector<ScheduleOperation>& schedule, const mpm::Particles& rest, const mpm::Region& region);
  Places places(const std::vector<int>& list, const mpm::Frame& frame, double ahead) const;
  Vec3d mean_velocity(const mpm::Frame& frame) const;
  void begin(const mpm::Frame& frame);
  double measure(const mpm::Frame& frame, double ahead);
  double share() const;
  std::string shortfall() const;
};

AchievementMeter::Meter::Meter(const ScheduleOperation& operation, const Candidate& candidate,
                               const mpm::Problem& problem, const Vec3d& up, double frame)
    : op(operation),
      frame_dt(frame),
      longest(longest_side(problem.particles.position)),
      quantity(quantity_of(operation.kind)),
      material(stiffest(operation.rows, candidate)),
      gravity(problem.domain.gravity) {
  const mpm::Region region = choose(problem.particles, up);
  ask(candidate.schedule, problem.particles, region);
}

// The particles that are measured, and the axis; returns where the former lie.
mpm::Region AchievementMeter::Meter::choose(const mpm::Particles& rest, const Vec3d& up) {
  const Vec3d direction = to_mpm(op.direction);
  rows = op.rows;
  axis = unit(to_mpm(op.velocity));
  Vec3d end = {0, 0, 1};
  double fraction = 1;
  switch (op.kind) {
    case Kind::top_press:
      end = up, fraction = op.slab_fraction;
      break;
    case Kind::radial_spread:
    case Kind::vertical_compress:
      axis = end = up;
      break;
    case Kind::side_compress:
    case Kind::scale:
      axis = direction, end = -direction, fraction = op.slab_fraction;
      break;
    case Kind::torque:
    case Kind::support_hold:
      axis = end = direction, fraction = op.slab_fraction;
      break;
    case Kind::drag_pair:
      // What is pulled, where a source pulls: all of it, not only the part that is held on to.
      if (op.follow != Follow::none) rows = op.neighbours;
      end = direction, fraction = op.follow == Follow::none ? op.slab_fraction : 1;
      break;
    default:
      break;
  }
  const mpm::Region region = mpm::select_slab(rows, end, fraction, rest);
  particles = region.particles;
  extent = region.extent.length();
  if (op.kind == Kind::side_compress || op.kind == Kind::scale)
    far_end = mpm::select_slab(rows, direction, fraction, rest).particles;
  return region;
}

// What the action asks for over its interval, and how much of that its speed limit leaves.
void AchievementMeter::Meter::ask(const std::vector<ScheduleOperation>& schedule, const mpm::Particles& rest,
                                  const mpm::Region& region) {
  const double duration = op.end - op.start;
  const auto ratio_within = [&](double ratio, double change_limit) {
    const double most = extent > 0 ? change_limit * duration / extent : 0;
    return 1 + std::clamp(ratio - 1, -most, most);
  };
  switch (op.kind) {
    case Kind::torque:
      requested = op.rate * duration;
      reachable = bounded_rate(bind_torque(op), mpm::select_region(bind_torque(op), rest)) * duration;
      break;
    case Kind::impulse:
      requested = reachable = op.velocity.norm();
      break;
    case Kind::radial_spread:
      requested = reachable = region.radius > 0 ? 1 + op.speed_limit * duration / region.radius : 1;
      break;
    case Kind::support_hold:
      requested = reachable = 0;
      break;
    case Kind::vertical_compress:
      requested = op.ratio;
      reachable = ratio_within(op.ratio, op.speed_limit);
      break;
    case Kind::side_compress:
      requested = squeezed_ratio(op, schedule);
      reachable = ratio_within(requested, (1 - requested) / std::max(1 - op.ratio, 1e-300) * op.speed_limit);
      break;
    case Kind::scale:
      requested = op.ratio;
      reachable = ratio_within(op.ratio, 2 * op.speed_limit);
      break;
    default:
      requested = reachable = op.velocity.norm() * duration;
  }
}

// Where the listed particles are `ahead` seconds after the frame if each goes on with its velocity.
Places AchievementMeter::Meter::places(const std::vector<int>& list, const mpm::Frame& frame, double ahead) const {
  Places found;
  found.reserve(list.size());
  for (const int i : list) found.push_back(frame.state.x[i] + ahead * frame.state.v[i]);
  return found;
}

Vec3d AchievementMeter::Meter::mean_velocity(const mpm::Frame& frame) const {
  Vec3d sum{0, 0, 0};
  for (const int i : particles) sum = sum + frame.state.v[i];
  return (1.0 / static_cast<double>(particles.size())) * sum;
}

void AchievementMeter::Meter::begin(const mpm::Frame& frame) {
  const double ahead = std::max(0.0, op.start - frame.time);
  start = before = places(particles, frame, ahead);
  far_start = places(far_end, frame, ahead);
  const Vec3d now = mean_velocity(frame);
  if (began) acceleration = (1 / frame_dt) * (now - velocity);
  velocity = now;
  last_frame = frame.time;
  began = true;
}

void AchievementMeter::Meter::observe(const mpm::Frame& frame) {
  const double slack = 1e-6 * frame_dt, left = op.end - frame.time;
  if (particles.empty() || ended) return;
  if (frame.time <= op.start + slack) return begin(frame);
  if (op.kind == Kind::impulse && left > slack) return;
  // Beyond the end only what a frame has not caught within the interval.
  if (left >= -slack || !moved) achieved = measure(frame, left > 0 && left < frame_dt ? left : 0);
  moved = true;
  ended = left < frame_dt - slack;
}

double AchievementMeter::Meter::measure(const mpm::Frame& frame, double ahead) {
  const Places now = places(particles, frame, ahead);
  switch (op.kind) {
    case Kind::torque: {
      const Places here = places(particles, frame, 0);
      turned += mpm::turn_about(axis, before, here);
      before = here;
      return turned + mpm::turn_about(axis, here, now);
    }
    case Kind::impulse: {
      // Less what would have happened anyway: it goes on falling, or loses speed to gravity once it is off the ground.
      const double since = frame.time - op.end;
      const Vec3d free = velocity + (frame.time - last_frame) * acceleration;
      const double pull = dot(axis, gravity);
      const bool falls = dot(acceleration, gravity) > 0.5 * dot(gravity, gravity);
      const double lost = pull < 0 && !falls ? -pull * since : 0;
      return dot(axis, mean_velocity(frame) - free) + lost;
    }
    case Kind::radial_spread: {
      const double at_start = mpm::radius_about(axis, start);
      return at_start > 0 ? mpm::radius_about(axis, now) / at_start : 1;
    }
    case Kind::support_hold:
      return mpm::mean_distance(start, now);
    case Kind::vertical_compress:
      return mpm::stretch_along(axis, start, now);
    case Kind::side_compress:
    case Kind::scale: {
      const double was = dot(axis, mpm::center_of(far_start) - mpm::center_of(start));
      const double is = dot(axis, mpm::center_of(places(far_end, frame, ahead)) - mpm::center_of(now));
      return extent > 0 ? 1 + (is - was) / extent : 1;
    }
    default:
      return dot(axis, mpm::center_of(now) - mpm::center_of(start));
  }
}

double AchievementMeter::Meter::share() const {
  if (!moved || !std::isfinite(achieved)) return 0;
  if (op.kind == Kind::support_hold) return stillness_share(achieved, longest);
  const double from = quantity == "ratio" || quantity == "spread" ? 1 : 0;
  // Nothing was asked for, so nothing is missing.
  if (std::abs(requested - from) < 1e-9) return 1;
  return std::clamp((achieved - from) / (requested - from), 0.0, 1.0);
}

std::string AchievementMeter::Meter::shortfall() const {
  if (share() >= kMet) return "";
  if (!moved) return "the run ended before it; give it an earlier start or the run more frames";
  if (!ended) return "the run ended before its end; give it less time or the run more frames";
  const double from = quantity == "ratio" || quantity == "spread" ? 1 : 0;
  // Of a hold nothing is bounded.
  const double within = std::abs(requested - from) > 0 ? (reachable - from) / (requested - from) : 1;
  if (within < kMet && share() >= kMet * within) {
    if (op.enforced) {
      return fmt::format(
          "it is bounded to {:.3g} of that, so that nothing breaks or is thrown (speed {:.3g} m/s, shear {:.3g}); give "
          "it "
          "more time or ask for less",
          within, op.speed_limit, op.strain_limit);
    }
    return fmt::format(
        "its speed is bounded to {:.3g} m/s, which leaves {:.3g} of it; give it more time or ask for less",
        op.speed_limit, within);
  }
  const unsigned fields = operation_fields(op.kind);
  if ((fields & kHasBlendTime) && op.kind != Kind::drag_pair && !op.enforced) {
    return fmt::format("its bounded force does not move {}; choose a softer material (MATERIAL=){}", material,
                       op.kind == Kind::torque ? ", or controls.stiff=enforced" : "");
  }
  if (op.kind == Kind::impulse)
    return "what it hit is held back by what it is fixed to or rests on; hit harder, or a part that is free";
  return "something held it back: a wall, an obstacle, or another action on the same rows";
}

AchievedAction AchievementMeter::Meter::result() const {
  AchievedAction a;
  a.type = op.kind;
  a.quantity = quantity;
  a.unit = unit_of(quantity);
  a.requested = requested;
  a.achieved = moved && std::isfinite(achieved) ? achieved : quantity == "ratio" || quantity == "spread" ? 1 : 0;
  a.share = share();
  a.shortfall = shortfall();
  return a;
}

AchievementMeter::AchievementMeter(const Candidate& candidate, const mpm::Problem& problem, const Vec3d& up,
                                   double frame_dt) {
  for (const CandidateRow& row : candidate.rows) key_of_[row.row] = row.key;
  for (const ScheduleOperation& op : candidate.schedule) {
    if (op.is_action()) meters_.emplace_back(op, candidate, problem, up, frame_dt);
  }
}

AchievementMeter::~AchievementMeter() = default;

void AchievementMeter::observe(const mpm::Frame& frame) {
  for (Meter& meter : meters_) meter.observe(frame);
}

std::vector<AchievedAction> AchievementMeter::result() const {
  std::vector<AchievedAction> list;
  for (const Meter& meter : meters_) {
    list.push_back(meter.result());
    for (const int row : meter.rows) {
      const auto key = key_of_.find(row);
      if (key != key_of_.end()) list.back().rows.push_back(key->second);
    }
  }
  return list;
}

}  // namespace physmas::bind
