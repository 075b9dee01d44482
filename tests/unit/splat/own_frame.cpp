// What turned is not flattened: the last frame in the objects' own frame.
#include "splat/own_frame.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <random>

#include "unit/splat/motion.h"

using namespace physmas;
using namespace physmas::splat;
using doctest::Approx;
using splat_test::balls;
using splat_test::Motion;

namespace {

// A standing stick: nine balls above each other, and a tenth beside the middle so that its shape tells a turn.
std::vector<Eigen::Vector3f> stick() {
  std::vector<Eigen::Vector3f> places;
  for (int i = -4; i <= 4; ++i) places.push_back({0, 0.15f * i, 0});
  places.push_back({0.05f, 0.1f, 0.02f});
  return places;
}

std::vector<Eigen::Vector3f> moved(const std::vector<Eigen::Vector3f>& places, const Eigen::Matrix3f& A,
                                   const Eigen::Vector3f& by = Eigen::Vector3f::Zero()) {
  std::vector<Eigen::Vector3f> result;
  for (const Eigen::Vector3f& p : places) result.push_back(A * p + by);
  return result;
}

Eigen::Matrix3f turn(float degrees, const Eigen::Vector3f& axis) {
  return Eigen::AngleAxisf(degrees * static_cast<float>(M_PI) / 180, axis.normalized()).toRotationMatrix();
}

RigidMotion fitted(const std::vector<Eigen::Vector3f>& first, const std::vector<Eigen::Vector3f>& last) {
  std::vector<int32_t> members;
  for (size_t i = 0; i < first.size(); ++i) members.push_back(static_cast<int32_t>(i));
  const std::vector<RowMatrix3f> F(first.size(), RowMatrix3f::Identity());
  return fit_rigid_motion(TransportedFrame(first, F), TransportedFrame(last, F), members);
}

std::vector<Eigen::Vector3f> cloud(size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-0.5f, 0.5f);
  std::vector<Eigen::Vector3f> places(n);
  for (Eigen::Vector3f& p : places) p = {u(random), 2 * u(random), u(random)};
  return places;
}

void check_same_box(const FrameForeground& a, const FrameForeground& b) {
  REQUIRE(a.present);
  REQUIRE(b.present);
  CHECK(std::abs(a.x0 - b.x0) <= 1);
  CHECK(std::abs(a.x1 - b.x1) <= 1);
  CHECK(std::abs(a.y0 - b.y0) <= 1);
  CHECK(std::abs(a.y1 - b.y1) <= 1);
}

}  // namespace

TEST_CASE("splat: the best-fit rotation is the one that moved the points") {
  const auto places = cloud(200, 1);
  for (const float degrees : {0.0f, 10.0f, 90.0f, 179.0f}) {
    const Eigen::Matrix3f R = turn(degrees, {1, -2, 0.5f});
    const RigidMotion motion = fitted(places, moved(places, R, {3, 1, -2}));
    CHECK((motion.R.cast<float>() - R).norm() < 1e-4f);
    CHECK(motion.degrees() == Approx(degrees).epsilon(1e-3));
    CHECK(motion.likeness == Approx(1).epsilon(1e-5));
  }
  // A mirror image is no turn.
  const RigidMotion mirrored = fitted(places, moved(places, Eigen::Vector3f(-1, 1, 1).asDiagonal()));
  CHECK(mirrored.R.determinant() == Approx(1));
  CHECK(mirrored.likeness < 0.9);
  // What melts does not turn; what is mixed has no shape left.
  const RigidMotion melted = fitted(places, moved(places, Eigen::Vector3f(2, 0.3f, 2).asDiagonal()));
  CHECK(melted.degrees() < 5);
  CHECK(melted.likeness > kLeastLikeness);
  CHECK(fitted(places, cloud(200, 2)).likeness < kLeastLikeness);
  // One point, equal points, a point that is not finite.
  CHECK(fitted({{1, 2, 3}}, {{4, 5, 6}}).degrees() == 0);
  CHECK(fitted({{1, 2, 3}, {1, 2, 3}}, {{0, 0, 0}, {1, 0, 0}}).degrees() == 0);
  auto broken = moved(places, turn(90, {0, 0, 1}));
  broken[5].setConstant(NAN);
  CHECK(fitted(places, broken).degrees() == Approx(90));
}

TEST_CASE("splat: a stick that topples, tumbles through the air or comes near keeps its boxes in its own frame") {
  const auto places = stick();
  for (const auto& [R, by] : {std::pair<Eigen::Matrix3f, Eigen::Vector3f>(turn(90, {0, 0, 1}), {0, 0, 0}),
                              {turn(90, {0, 0, 1}), {2.5f, -1, 0}},
                              {turn(40, {0, 0.2f, 1}), {0, 0.3f, 0.4f}},
                              {Eigen::Matrix3f::Identity(), {0, 0, -2}}}) {
    Motion motion(balls(places), moved(places, R, by), std::vector<RowMatrix3f>(places.size(), R));
    const RenderRecord record = motion.record();
    const auto image = foreground_ratios(record.endpoint(0), record.endpoint(1));
    REQUIRE(image);
    CHECK((image->spread() || image->flattened()));
    REQUIRE(record.own_frame);
    check_same_box(record.own_frame->put_back, *record.endpoint(0));
    check_same_box(record.own_frame->turned_back, *record.endpoint(0));
    CHECK(record.own_frame->put_back.frame == 1);
    REQUIRE(record.own_frame->turns.size() == 1);
    CHECK(record.own_frame->turns[0].object == "thing");
    CHECK(record.own_frame->turns[0].likeness == Approx(1).epsilon(1e-5));
  }
}

TEST_CASE("splat: what holds in the image is not measured again") {
  const auto places = stick();
  Motion motion(balls(places), moved(places, turn(4, {0, 0, 1})));
  CHECK_FALSE(motion.record().own_frame);
}

TEST_CASE("splat: what melts or swells does so in its own frame, too, also when it turns") {
  const auto places = stick();
  for (const float degrees : {0.0f, 30.0f}) {
    const Eigen::Matrix3f puddle = turn(degrees, {0, 1, 0}) * Eigen::Vector3f(12, 0.25f, 12).asDiagonal();
    Motion melted(balls(places), moved(places, puddle));
    const RenderRecord record = melted.record();
    REQUIRE(record.own_frame);
    CHECK(foreground_ratios(record.endpoint(0), &record.own_frame->put_back)->flattened());
  }
  const Eigen::Matrix3f swollen = turn(90, {0, 0, 1}) * 3;
  Motion plate(balls(places), moved(places, swollen), std::vector<RowMatrix3f>(places.size(), swollen));
  const RenderRecord record = plate.record();
  REQUIRE(record.own_frame);
  CHECK(record.endpoint(1)->x1 > splat_test::kWidth);
  CHECK(foreground_ratios(record.endpoint(0), &record.own_frame->turned_back)->spread());
}

TEST_CASE("splat: every object turns about its own centre; flying apart still counts as spread") {
  // Two sticks above each other, each lying down after the fall, far apart.
  const auto half = moved(stick(), Eigen::Vector3f(1, 0.4f, 1).asDiagonal());
  auto places = moved(half, Eigen::Matrix3f::Identity(), {0, 0.3f, 0});
  const auto low = moved(half, Eigen::Matrix3f::Identity(), {0, -0.3f, 0});
  places.insert(places.end(), low.begin(), low.end());
  auto last = moved(half, turn(90, {0, 0, 1}), {1, 0, 0});
  const auto other = moved(half, turn(-90, {0, 0, 1}), {-1, 0, 0});
  last.insert(last.end(), other.begin(), other.end());
  Motion motion(balls(places), last);
  motion.state.row_keys = {"a/body", "b/body"};
  for (size_t i = half.size(); i < places.size(); ++i)
    motion.state.gaussian_object[i] = motion.state.gaussian_row[i] = 1;
  const RenderRecord record = motion.record();
  REQUIRE(record.own_frame);
  REQUIRE(record.own_frame->turns.size() == 2);
  CHECK(record.own_frame->turns[1].object == "b");
  CHECK(record.own_frame->turns[0].degrees == Approx(90).epsilon(1e-3));
  const FrameForeground& rest = *record.endpoint(0);
  check_same_box(record.own_frame->put_back, rest);
  CHECK(foreground_ratios(&rest, &record.own_frame->turned_back)->spread());
}
