// What actions achieved, measured on motions whose numbers are known.
#include "bind/achievement.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "bind/stillness.h"
#include "unit/mpm/scenes.h"

using namespace physmas;
using doctest::Approx;
using mpm::Vec3d;
using Kind = ScheduleOperation::Kind;

namespace {

constexpr double kFrame = 0.04;

// A block of row 0 that is 0.4 wide and 0.8 high, and where asked for a second one far to its right.
mpm::Problem block(bool second = false) {
  mpm::Problem p = mpm_test::scene({mpm::Branch::metal, 1e5, 0.3, 1000}, 32, {0, 0, -10});
  mpm_test::add_block(p, {0.8, 0.8, 0.4}, {1.2, 1.2, 1.2}, 0, p.domain.dx(), 0);
  if (second) mpm_test::add_block(p, {1.6, 0.8, 0.4}, {1.8, 1.2, 0.8}, 1, p.domain.dx(), 0);
  p.particles.velocity.clear();
  return p;
}

ScheduleOperation operation(Kind kind, double start, double end) {
  ScheduleOperation op;
  op.kind = kind;
  op.rows = {0};
  op.start = start;
  op.end = end;
  op.direction = {0, 0, 1};
  op.speed_limit = 10;
  return op;
}

Candidate candidate_of(const std::vector<ScheduleOperation>& schedule) {
  Candidate candidate;
  for (int row = 0; row < 2; ++row) {
    CandidateRow r;
    r.row = row;
    r.key = row == 0 ? "thing/body" : "other/body";
    r.branch = Branch::metal;
    r.E = 7e7;
    candidate.rows.push_back(r);
  }
  candidate.schedule = schedule;
  return candidate;
}

// Where a particle at `x` is after `t` seconds.
using Motion = std::function<Vec3d(const Vec3d& x, double t)>;

// The frames of a motion, with velocities by differences.
void play(const mpm::Problem& p, const Motion& motion, int frames,
          const std::function<void(const mpm::Frame&)>& observe) {
  for (int f = 0; f < frames; ++f) {
    mpm::State state;
    const double t = f * kFrame, h = 1e-6;
    for (const Vec3d& x : p.particles.position) {
      state.x.push_back(motion(x, t));
      state.v.push_back((1 / h) * (motion(x, t + h) - motion(x, t)));
    }
    observe({f, t, state});
  }
}

std::vector<AchievedAction> measured(const std::vector<ScheduleOperation>& schedule, const Motion& motion,
                                     int frames = 26, const mpm::Problem& p = block()) {
  bind::AchievementMeter meter(candidate_of(schedule), p, {0, 0, 1}, kFrame);
  play(p, motion, frames, [&](const mpm::Frame& frame) { meter.observe(frame); });
  return meter.result();
}

// 0 before `start`, 1 from `end` on.
double part(double t, double start, double end) {
  return std::min(1.0, std::max(0.0, (t - start) / (end - start)));
}

Vec3d turned(const Vec3d& x, double angle) {
  const Vec3d r = x - Vec3d{1, 1, 0};
  return {1 + std::cos(angle) * r.x - std::sin(angle) * r.y, 1 + std::sin(angle) * r.x + std::cos(angle) * r.y, r.z};
}

}  // namespace

TEST_CASE("bind achievement: a rod that turns by more than a revolution, measured at the end, not at a frame") {
  ScheduleOperation twist = operation(Kind::torque, 0.1, 0.77);
  twist.rate = 12;
  twist.slab_fraction = 0.25;
  const double asked = 12 * 0.67;
  for (const double reached : {1.0, 0.25}) {
    // It swings back at once: a frame after the end would show it.
    const auto list = measured({twist}, [&](const Vec3d& x, double t) {
      const double back = t > 0.77 ? 5 * (t - 0.77) : 0;
      return turned(x, reached * asked * part(t, 0.1, 0.77) - back);
    });
    REQUIRE(list.size() == 1);
    CHECK(list[0].type == ActionType::torque);
    CHECK(list[0].rows == std::vector<std::string>{"thing/body"});
    CHECK(list[0].quantity == "angle");
    CHECK(list[0].unit == "rad");
    CHECK(list[0].requested == Approx(asked));
    CHECK(list[0].achieved == Approx(reached * asked).epsilon(0.01));
    CHECK(list[0].share == Approx(reached).epsilon(0.01));
    CHECK(list[0].shortfall.empty() == (reached == 1));
  }
}

TEST_CASE("bind achievement: the other way round, nothing is achieved") {
  ScheduleOperation twist = operation(Kind::torque, 0.1, 0.5);
  twist.rate = -2;
  CHECK(measured({twist}, [](const Vec3d& x, double t) { return turned(x, 2 * part(t, 0.1, 0.5)); })[0].share == 0);
  CHECK(measured({twist}, [](const Vec3d& x, double t) { return turned(x, -0.8 * part(t, 0.1, 0.5)); })[0].share >
        0.999);
}

TEST_CASE("bind achievement: a block that is moved, whatever it did before") {
  ScheduleOperation push = operation(Kind::translation, 0.2, 0.7);
  push.velocity = {0.6, 0, 0.8};
  const auto list = measured({push}, [](const Vec3d& x, double t) {
    return x + part(t, 0.2, 0.7) * Vec3d{0.3, 0.7, 0.4} + Vec3d{std::min(t, 0.2), 0, 0};
  });
  CHECK(list[0].quantity == "displacement");
  CHECK(list[0].requested == Approx(0.5));
  CHECK(list[0].achieved == Approx(0.5));
  CHECK(list[0].share == Approx(1));
}

TEST_CASE("bind achievement: a press is measured on its slab, a pull on what is pulled") {
  ScheduleOperation press = operation(Kind::top_press, 0.1, 0.5);
  press.velocity = {0, 0, -0.5};
  press.slab_fraction = 0.2;
  const Motion top_half = [](const Vec3d& x, double t) {
    return x.z > 0.8 ? x - part(t, 0.1, 0.5) * Vec3d{0, 0, 0.1} : x;
  };
  CHECK(measured({press}, top_half)[0].achieved == Approx(0.1));
  CHECK(measured({press}, top_half)[0].share == Approx(0.5));

  ScheduleOperation drag = operation(Kind::drag_pair, 0, 0.5);
  drag.velocity = {0.4, 0, 0};
  drag.direction = {1, 0, 0};
  drag.follow = Follow::interface;
  drag.neighbours = {1};
  const Motion half_way = [](const Vec3d& x, double t) {
    return x + (x.x > 1.5 ? 0.1 : 0.2) * part(t, 0, 0.5) * Vec3d{1, 0, 0};
  };
  const auto list = measured({drag}, half_way, 26, block(true));
  CHECK(list[0].rows == std::vector<std::string>{"other/body"});
  CHECK(list[0].achieved == Approx(0.1));
  CHECK(list[0].share == Approx(0.5));
}

TEST_CASE("bind achievement: ratios of compression and stretching") {
  ScheduleOperation flatten = operation(Kind::vertical_compress, 0.1, 0.5);
  flatten.ratio = 0.6;
  const auto flat = measured({flatten}, [](const Vec3d& x, double t) {
    return Vec3d{x.x, x.y, 0.4 + (1 - 0.2 * part(t, 0.1, 0.5)) * (x.z - 0.4)};
  });
  CHECK(flat[0].quantity == "ratio");
  CHECK(flat[0].unit.empty());
  CHECK(flat[0].achieved == Approx(0.8));
  CHECK(flat[0].share == Approx(0.5));

  // Two hands: each slab goes half of the way, and both together are what was asked.
  ScheduleOperation left = operation(Kind::side_compress, 0.1, 0.5), right = left;
  left.direction = {1, 0, 0}, right.direction = {-1, 0, 0};
  left.ratio = right.ratio = 0.8;
  left.slab_fraction = right.slab_fraction = 0.2;
  const Motion squeeze = [](const Vec3d& x, double t) {
    const double side = x.x < 0.9 ? 1 : x.x > 1.1 ? -1 : 0;
    return x + 0.04 * side * part(t, 0.1, 0.5) * Vec3d{1, 0, 0};
  };
  for (const AchievedAction& a : measured({left, right}, squeeze)) {
    CHECK(a.requested == Approx(0.6));
    CHECK(a.achieved == Approx(1 - 0.08 / 0.375));  // of the extent of the particles: 0.4 less one spacing
    CHECK(a.share == Approx(0.5).epsilon(0.1));
    CHECK(a.shortfall.find("Metal of 7e+07 Pa") != std::string::npos);
  }
  // A body that is shoved as a whole is not squeezed.
  const auto shoved = measured({left}, [](const Vec3d& x, double t) {
    return x + 0.08 * part(t, 0.1, 0.5) * Vec3d{1, 0, 0};
  });
  CHECK(shoved[0].share < 1e-9);

  ScheduleOperation stretch = operation(Kind::scale, 0.1, 0.5);
  stretch.ratio = 1.5;
  stretch.slab_fraction = 0.2;
  const auto longer = measured({stretch}, [](const Vec3d& x, double t) {
    return Vec3d{x.x, x.y, x.z + 0.5 * part(t, 0.1, 0.5) * (x.z - 0.8)};
  });
  CHECK(longer[0].share > 0.75);  // the slabs' centres, a tenth from the ends, move that much less
  CHECK(longer[0].share < 0.9);
}

TEST_CASE("bind achievement: a blow is the speed it gives, beside falling and what gravity takes back") {
  for (const bool falls : {false, true}) {
    CAPTURE(falls);
    for (const double direction : {1.0, -1.0}) {
      if (direction < 0 && !falls) continue;  // into the floor
      ScheduleOperation hit = operation(Kind::impulse, 0.1, 0.1008);
      hit.velocity = {0.9, 0, 1.2 * direction};
      const auto list = measured({hit}, [&](const Vec3d& x, double t) {
        const double after = std::max(0.0, t - 0.1), air = falls ? t : after;
        return x + after * Vec3d{0.9, 0, 1.2 * direction} - Vec3d{0, 0, 5 * air * air};
      });
      CHECK(list[0].quantity == "speed");
      CHECK(list[0].unit == "m/s");
      CHECK(list[0].requested == Approx(1.5));
      CHECK(list[0].achieved == Approx(1.5).epsilon(0.02));
    }
  }
}

TEST_CASE("bind achievement: spreading, holding") {
  ScheduleOperation melt = operation(Kind::radial_spread, 0.1, 0.5);
  melt.speed_limit = 0.25;
  const double radius = 0.1875 * std::sqrt(2.0);  // of the outermost particles
  const auto spread = measured({melt}, [&](const Vec3d& x, double t) {
    const double grown = 1 + 0.5 * 0.1 / radius * part(t, 0.1, 0.5);
    return Vec3d{1 + grown * (x.x - 1), 1 + grown * (x.y - 1), x.z - t};
  });
  CHECK(spread[0].quantity == "spread");
  CHECK(spread[0].requested == Approx(1 + 0.1 / radius).epsilon(0.1));
  CHECK(spread[0].share == Approx(0.5).epsilon(0.1));

  const ScheduleOperation hold = operation(Kind::support_hold, 0, 1);
  CHECK(measured({hold}, [](const Vec3d& x, double) { return x; })[0].share == 1);
  // A tenth of the longest side is no holding any more.
  const double twentieth = bind::longest_side(block().particles.position) / 20;
  const auto drifting = measured({hold}, [&](const Vec3d& x, double t) { return x + Vec3d{twentieth * t, 0, 0}; });
  CHECK(drifting[0].quantity == "drift");
  CHECK(drifting[0].achieved == Approx(twentieth));
  CHECK(drifting[0].share == Approx(0.5));
}

TEST_CASE("bind achievement: bounds, short actions, and runs that end early") {
  ScheduleOperation twist = operation(Kind::torque, 0.1, 0.5);
  twist.rate = 8;
  twist.speed_limit = 0.5;  // of 8 rad/s at a quarter of a metre
  const auto bounded = measured({twist}, [](const Vec3d& x, double t) { return turned(x, 0.7 * part(t, 0.1, 0.5)); });
  CHECK(bounded[0].shortfall.find("its speed is bounded to 0.5 m/s") != std::string::npos);
  // It did not even reach its bound: that is not why.
  const auto stuck = measured({twist}, [](const Vec3d& x, double t) { return turned(x, 0.1 * part(t, 0.1, 0.5)); });
  CHECK(stuck[0].shortfall.find("its bounded force does not move Metal of 7e+07 Pa") != std::string::npos);
  twist.enforced = true;
  twist.slab_fraction = 0.2;
  twist.strain_limit = 0.25;
  const auto sheared = measured({twist}, [](const Vec3d& x, double t) { return turned(x, 0.44 * part(t, 0.1, 0.5)); });
  CHECK(sheared[0].shortfall.find("so that nothing breaks or is thrown (speed 0.5 m/s, shear 0.25)") !=
        std::string::npos);

  // Between two frames: the frame after it tells.
  ScheduleOperation push = operation(Kind::translation, 0.045, 0.075);
  push.velocity = {1, 0, 0};
  const Motion motion = [](const Vec3d& x, double t) { return x + 0.03 * part(t, 0.045, 0.075) * Vec3d{1, 0, 0}; };
  CHECK(measured({push}, motion)[0].share == Approx(1));

  push = operation(Kind::translation, 0.1, 0.5);
  push.velocity = {1, 0, 0};
  const Motion steady = [](const Vec3d& x, double t) { return x + 0.4 * part(t, 0.1, 0.5) * Vec3d{1, 0, 0}; };
  const auto cut = measured({push}, steady, 6);  // to 0.2 s
  CHECK(cut[0].achieved == Approx(0.1));
  CHECK(cut[0].shortfall.find("ended") != std::string::npos);
  const auto never = measured({push}, steady, 2);
  CHECK(never[0].achieved == 0);
  CHECK(never[0].share == 0);
  CHECK(never[0].shortfall.find("ended before") != std::string::npos);
  // What is no number is nothing.
  const auto lost = measured({push}, [](const Vec3d& x, double t) { return (t > 0.3 ? std::nan("") : 1.0) * x; });
  CHECK(lost[0].share == 0);
  CHECK(lost[0].achieved == 0);
}

TEST_CASE("bind achievement: the line for a person") {
  AchievedAction a;
  a.type = ActionType::torque;
  a.rows = {"guitar/neck", "guitar/headstock"};
  a.quantity = "angle", a.unit = "rad";
  a.requested = 2.15, a.achieved = 0.1222;
  a.shortfall = "because";
  CHECK(bind::shortfall_line(a) == "torque of guitar/neck, guitar/headstock: angle 7 of 123 degrees: because");
}

TEST_CASE("bind stillness: what stands untouched, and only that") {
  const mpm::Problem p = [] {
    mpm::Problem problem = block(true);
    problem.domain.colliders.push_back(mpm_test::floor_at(0.38));
    return problem;
  }();
  const auto still = [&](const std::vector<ScheduleOperation>& schedule, const Motion& motion,
                         const mpm::Problem& problem) {
    bind::StillnessMeter meter(candidate_of(schedule), problem);
    play(problem, motion, 26, [&](const mpm::Frame& frame) { meter.observe(frame); });
    return meter.result();
  };
  const Motion rest = [](const Vec3d& x, double) { return x; };
  const Motion sags = [](const Vec3d& x, double t) { return x.x > 1.5 ? x - Vec3d{0, 0, 0.0485 * t} : x; };
  ScheduleOperation push = operation(Kind::translation, 0.1, 0.5);
  const double longest = bind::longest_side(p.particles.position);
  CHECK(bind::longest_side({{0, 1, 0}, {1, -1, 0.5}}) == 2);

  auto s = still({}, rest, p);
  REQUIRE(s);
  CHECK(s->rows == std::vector<std::string>{"thing/body", "other/body"});
  CHECK(s->drift == 0);
  CHECK(s->share == 1);
  // One is pushed: the other must stand.
  s = still({push}, sags, p);
  REQUIRE(s);
  CHECK(s->rows == std::vector<std::string>{"other/body"});
  CHECK(s->drift == Approx(0.0485));
  CHECK(s->share == Approx(1 - 0.0485 / (0.1 * longest)));
  // Until it comes near.
  CHECK_FALSE(still(
      {push},
      [](const Vec3d& x, double t) {
        return x.x < 1.5 ? x + Vec3d{0.35 * t, 0, 0} : x;
      },
      p));
  // In the air nothing stands, without gravity all does.
  CHECK_FALSE(still({}, rest, block()));
  mpm::Problem weightless = block();
  weightless.domain.gravity = {0, 0, 0};
  CHECK(still({}, rest, weightless));
  // What is lost is not still.
  s = still(
      {}, [](const Vec3d& x, double t) { return (t > 0.5 ? std::nan("") : 1.0) * x; }, p);
  REQUIRE(s);
  CHECK(s->share == 0);
}
