// Each operation of a schedule becomes its action or projection, with every number where it belongs.
#include "bind/schedule.h"

#include <doctest/doctest.h>

#include <cmath>
#include <variant>

using namespace physmas;

namespace {

using Kind = ScheduleOperation::Kind;

// An operation in which no two fields have the same value.
ScheduleOperation operation(Kind kind) {
  ScheduleOperation op;
  op.kind = kind;
  op.rows = {2, 4};
  op.velocity = {0.1, -0.2, 0.3};
  op.direction = {0.6, 0, -0.8};
  op.start = 0.25;
  op.end = 0.75;
  op.slab_fraction = 0.15;
  op.ratio = 0.65;
  op.rate = 2.5;
  op.speed_limit = 0.45;
  op.blend_time = 3e-3;
  op.position_weight = 0.11;
  op.strain_limit = 0.7;
  op.release = 0.35;
  op.distance = 0.07;
  op.neighbours = {1, 3};
  op.eta = 0.85;
  return op;
}

RunSpecification run() {
  RunSpecification run;
  run.placement.up = "-y";
  run.time.substep_dt = 1.5e-4;
  return run;
}

mpm::Schedule schedule_of(const ScheduleOperation& op) {
  Candidate candidate;
  candidate.schedule = {op};
  return bind::bind_schedule(candidate, run());
}

// The only action of the operation's schedule.
template <class Action>
Action action_of(const ScheduleOperation& op) {
  const mpm::Schedule schedule = schedule_of(op);
  REQUIRE(schedule.actions.size() == 1);
  CHECK(schedule.projections.empty());
  CHECK(schedule.retentions.empty());
  REQUIRE(std::holds_alternative<Action>(schedule.actions[0]));
  return std::get<Action>(schedule.actions[0]);
}

bool same(const mpm::Vec3d& a, const Eigen::Vector3d& b) {
  return a.x == b.x() && a.y == b.y() && a.z == b.z();
}

// What every action has: its rows and its interval.
template <class Action>
void check_common(const Action& action) {
  CHECK(action.rows == std::vector<int>{2, 4});
  CHECK(action.start == 0.25);
  CHECK(action.end == 0.75);
}

const Eigen::Vector3d kVelocity(0.1, -0.2, 0.3), kDirection(0.6, 0, -0.8), kUp(0, -1, 0);

}  // namespace

TEST_CASE("bind: translation and top_press enforce the operation's velocity") {
  const auto translation = action_of<mpm::Translation>(operation(Kind::translation));
  check_common(translation);
  CHECK(same(translation.velocity, kVelocity));

  const auto press = action_of<mpm::TopPress>(operation(Kind::top_press));
  check_common(press);
  CHECK(same(press.velocity, kVelocity));
  CHECK(same(press.towards, kUp));
  CHECK(press.slab_fraction == 0.15);
  CHECK(press.release == 0.35);
}

TEST_CASE("bind: radial_spread, vertical_compress and side_compress") {
  const auto spread = action_of<mpm::RadialSpread>(operation(Kind::radial_spread));
  check_common(spread);
  CHECK(same(spread.up, kUp));
  CHECK(spread.speed == 0.45);
  CHECK(spread.blend_time == 3e-3);
  CHECK(spread.position == 0.11);

  const auto vertical = action_of<mpm::VerticalCompress>(operation(Kind::vertical_compress));
  check_common(vertical);
  CHECK(same(vertical.up, kUp));
  CHECK(vertical.ratio == 0.65);
  CHECK(vertical.speed_limit == 0.45);
  CHECK(vertical.release == 0.35);

  const auto side = action_of<mpm::SideCompress>(operation(Kind::side_compress));
  check_common(side);
  CHECK(same(side.direction, kDirection));
  CHECK(side.ratio == 0.65);
  CHECK(side.slab_fraction == 0.15);
  CHECK(side.speed_limit == 0.45);
  CHECK(side.blend_time == 3e-3);
  CHECK(side.position == 0.11);
  CHECK(side.release == 0.35);
}

TEST_CASE("bind: drag_pair is its puller, then who follows: nobody, the whole target, or what is near") {
  for (const Follow follow : {Follow::none, Follow::target, Follow::interface}) {
    ScheduleOperation op = operation(Kind::drag_pair);
    op.follow = follow;
    const mpm::Schedule schedule = schedule_of(op);
    REQUIRE(schedule.actions.size() == (follow == Follow::none ? 1 : 2));
    REQUIRE(std::holds_alternative<mpm::SlabMotion>(schedule.actions[0]));
    const auto& puller = std::get<mpm::SlabMotion>(schedule.actions[0]);
    check_common(puller);
    CHECK(same(puller.velocity, kVelocity));
    CHECK(same(puller.towards, kDirection));
    CHECK(puller.slab_fraction == 0.15);
    CHECK(puller.release == 0);
    if (follow == Follow::none) continue;
    REQUIRE(std::holds_alternative<mpm::DragFollow>(schedule.actions[1]));
    const auto& follower = std::get<mpm::DragFollow>(schedule.actions[1]);
    CHECK(follower.rows == std::vector<int>{1, 3});
    CHECK(follower.pullers == std::vector<int>{2, 4});
    CHECK(same(follower.velocity, kVelocity));
    CHECK(follower.blend_time == 3e-3);
    CHECK(follower.start == 0.25);
    CHECK(follower.end == 0.75);
    if (follow == Follow::target)
      CHECK(std::isinf(follower.distance));
    else
      CHECK(follower.distance == 0.07);
  }
}

TEST_CASE("bind: a scale is two slabs that move apart or together") {
  const mpm::Schedule schedule = schedule_of(operation(Kind::scale));
  REQUIRE(schedule.actions.size() == 2);
  const Eigen::Vector3d axes[] = {kDirection, -kDirection};
  for (size_t i = 0; i < 2; ++i) {
    REQUIRE(std::holds_alternative<mpm::ScaleSlab>(schedule.actions[i]));
    const auto& slab = std::get<mpm::ScaleSlab>(schedule.actions[i]);
    check_common(slab);
    CHECK(same(slab.axis, axes[i]));
    CHECK(slab.ratio == 0.65);
    CHECK(slab.slab_fraction == 0.15);
    CHECK(slab.speed_limit == 0.45);
    CHECK(slab.release == 0.35);
  }
}

TEST_CASE("bind: impulse, torque and support_hold") {
  const auto impulse = action_of<mpm::Impulse>(operation(Kind::impulse));
  CHECK(impulse.rows == std::vector<int>{2, 4});
  CHECK(same(impulse.velocity_change, kVelocity));
  CHECK(impulse.start == 0.25);
  CHECK(impulse.duration == 0.5);
  CHECK(impulse.base_step == 1.5e-4);

  const auto torque = action_of<mpm::Torque>(operation(Kind::torque));
  check_common(torque);
  CHECK(same(torque.axis, kDirection));
  CHECK(torque.rate == 2.5);
  CHECK(torque.slab_fraction == 0.15);
  CHECK(torque.speed_limit == 0.45);
  CHECK(torque.blend_time == 3e-3);
  CHECK(torque.release == 0.35);
  CHECK_FALSE(torque.enforced);
  CHECK(std::isinf(torque.strain_limit));  // it bounds itself
  ScheduleOperation stiff = operation(Kind::torque);
  stiff.enforced = true;
  CHECK(action_of<mpm::Torque>(stiff).enforced);
  CHECK(action_of<mpm::Torque>(stiff).strain_limit == 0.7);

  const auto hold = action_of<mpm::SlabMotion>(operation(Kind::support_hold));
  check_common(hold);
  CHECK(same(hold.velocity, {0, 0, 0}));
  CHECK(same(hold.towards, kDirection));
  CHECK(hold.slab_fraction == 0.15);
  CHECK(hold.release == 0);
}

TEST_CASE("bind: projections and retentions, one per row") {
  for (const bool rigid : {false, true}) {
    ScheduleOperation op = operation(Kind::structure_projection);
    op.rigid = rigid;
    const mpm::Schedule schedule = schedule_of(op);
    CHECK(schedule.actions.empty());
    CHECK(schedule.retentions.empty());
    REQUIRE(schedule.projections.size() == 2);
    for (size_t i = 0; i < 2; ++i) {
      CHECK(schedule.projections[i].row == op.rows[i]);
      CHECK(schedule.projections[i].eta == 0.85);
      CHECK(schedule.projections[i].mode ==
            (rigid ? mpm::StructureProjection::Mode::rigid : mpm::StructureProjection::Mode::literal));
    }
  }
  const mpm::Schedule schedule = schedule_of(operation(Kind::interface_retention));
  CHECK(schedule.actions.empty());
  CHECK(schedule.projections.empty());
  REQUIRE(schedule.retentions.size() == 2);
  for (size_t i = 0; i < 2; ++i) {
    CHECK(schedule.retentions[i].support == (i == 0 ? 2 : 4));
    CHECK(schedule.retentions[i].rows == std::vector<int>{1, 3});
    // The paper's constants, which no record changes.
    CHECK(schedule.retentions[i].distance == 0.045);
    CHECK(schedule.retentions[i].limit == 26000);
    CHECK(schedule.retentions[i].eta == 0.95);
    CHECK(schedule.retentions[i].zeta == 0.95);
  }
}

TEST_CASE("bind: operations keep their order") {
  Candidate candidate;
  for (const Kind kind : {Kind::torque, Kind::translation, Kind::impulse})
    candidate.schedule.push_back(operation(kind));
  const mpm::Schedule schedule = bind::bind_schedule(candidate, run());
  REQUIRE(schedule.actions.size() == 3);
  CHECK(std::holds_alternative<mpm::Torque>(schedule.actions[0]));
  CHECK(std::holds_alternative<mpm::Translation>(schedule.actions[1]));
  CHECK(std::holds_alternative<mpm::Impulse>(schedule.actions[2]));
}
