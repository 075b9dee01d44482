// Motion metrics against closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "eval/motion.h"

using namespace physmas::eval;

namespace {

// A 5x5 grid of points, 10 pixels apart, moved by `motion` in frame 1.
Tracks grid_tracks(const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& motion) {
  Tracks tracks;
  tracks.width = 200;
  tracks.height = 100;
  tracks.position.resize(2);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) {
      const Eigen::Vector2d p(20 + 10 * x, 30 + 10 * y);
      tracks.position[0].push_back(p);
      tracks.position[1].push_back(motion(p));
    }
  }
  tracks.visible.assign(2, std::vector<uint8_t>(25, 1));
  return tracks;
}

Eigen::Vector2d still(const Eigen::Vector2d& p) {
  return p;
}

}  // namespace

TEST_CASE("eval: a translated video has the translation as trajectory error, and no strain error") {
  const Tracks reference = grid_tracks(still);
  const Tracks predicted =
      grid_tracks([](const Eigen::Vector2d& p) { return Eigen::Vector2d(p + Eigen::Vector2d(4, 3)); });
  // Half of the pairs (frame 1) are off by (4/200, 3/100).
  const Measurement trajectory = trajectory_nrmse(reference, predicted);
  REQUIRE(trajectory.valid);
  CHECK(trajectory.value == doctest::Approx(100 * std::sqrt(0.5 * (0.02 * 0.02 + 0.03 * 0.03))));
  CHECK(trajectory.samples == 50);
  const Measurement strain = strain_rmse(reference, predicted);
  REQUIRE(strain.valid);
  // The ridge shifts both gradients alike; what is left is rounding.
  CHECK(strain.value == doctest::Approx(0).epsilon(1e-9));
}

TEST_CASE("eval: stretch and shear have their closed-form Green-Lagrange strains") {
  Eigen::Matrix2d F;
  F << 1.2, 0.3, 0, 0.9;
  const Tracks reference = grid_tracks(still);
  const Tracks predicted = grid_tracks([&](const Eigen::Vector2d& p) { return Eigen::Vector2d(F * p); });
  const Eigen::Matrix2d E = 0.5 * (F.transpose() * F - Eigen::Matrix2d::Identity());
  // Frame 0 agrees and counts, so the mean square is half of the strain's; the ridge perturbs F by about 1e-6.
  const Measurement strain = strain_rmse(reference, predicted);
  REQUIRE(strain.valid);
  CHECK(strain.value == doctest::Approx(100 * std::sqrt(0.5) * E.norm()).epsilon(1e-5));
}

TEST_CASE("eval: a rotated video has no strain error") {
  const double c = std::cos(0.7), s = std::sin(0.7);
  const Tracks rotated = grid_tracks(
      [&](const Eigen::Vector2d& p) { return Eigen::Vector2d(c * p.x() - s * p.y(), s * p.x() + c * p.y()); });
  CHECK(strain_rmse(grid_tracks(still), rotated).value < 1e-3);  // the ridge is 1e-6 of F
}

TEST_CASE("eval: pairs count only where both videos see the point") {
  const Tracks reference = grid_tracks(still);
  Tracks predicted = grid_tracks([](const Eigen::Vector2d& p) { return Eigen::Vector2d(p + Eigen::Vector2d(10, 0)); });
  for (int i = 0; i < 9; ++i) predicted.visible[1][i] = 0;
  CHECK(trajectory_nrmse(reference, predicted).samples == 25 + 16);
  predicted.visible[1][9] = 0;  // fifteen left: the frame is excluded
  CHECK(trajectory_nrmse(reference, predicted).samples == 25);
  for (auto& frame : predicted.visible) std::fill(frame.begin(), frame.end(), 0);
  const Measurement none = trajectory_nrmse(reference, predicted);
  CHECK_FALSE(none.valid);
  CHECK(none.reason.find("16") != std::string::npos);
  CHECK_FALSE(strain_rmse(reference, predicted).valid);
}

TEST_CASE("eval: fewer frames or points than the reference is invalid, not zero") {
  const Tracks reference = grid_tracks(still);
  Tracks shorter = reference;
  shorter.position.pop_back();
  shorter.visible.pop_back();
  CHECK_FALSE(trajectory_nrmse(reference, shorter).valid);
  CHECK_FALSE(strain_rmse(reference, shorter).valid);
  CHECK_FALSE(area_log_rmse({1, 2}, {1}).valid);
}

TEST_CASE("eval: points on a line have no local deformation") {
  Tracks line = grid_tracks(still);
  for (auto& frame : line.position) {
    for (Eigen::Vector2d& p : frame) p.y() = 50;
  }
  CHECK_FALSE(strain_rmse(line, line).valid);
}

TEST_CASE("eval: areas compare by logarithm, and an empty mask stays finite") {
  CHECK(area_log_rmse({100, 100}, {100, 100}).value == 0);
  CHECK(area_log_rmse({99, 99}, {199, 199}).value == doctest::Approx(100 * std::log(2.0)));
  CHECK(area_log_rmse({0}, {99}).value == doctest::Approx(100 * std::log(100.0)));
}
