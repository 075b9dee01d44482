// Motion metrics against closed forms.
#include "metrics/motion.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

using namespace physmas::metrics;

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

TEST_CASE("eval: areas compare by logarithm, and a mask that empties stays finite") {
  CHECK(area_log_rmse({100, 100}, {100, 100}).value == 0);
  CHECK(area_log_rmse({99, 99}, {199, 199}).value == doctest::Approx(100 * std::log(2.0)));
  CHECK(area_log_rmse({99, 0}, {99, 99}).value == doctest::Approx(100 * std::log(100.0) / std::sqrt(2.0)));
}

TEST_CASE("eval: a target that frame 0 does not show is invalid, not zero") {
  CHECK_FALSE(area_log_rmse({0, 0}, {0, 0}).valid);
  CHECK(area_log_rmse({5, 5}, {0, 5}).reason.find("frame 0") != std::string::npos);
  CHECK_FALSE(area_log_rmse({}, {}).valid);
}

TEST_CASE("eval: an object scaled about its middle has closed-form track, area and strain errors") {
  const double s = 1.5;
  const Eigen::Vector2d middle(40, 50);
  const Tracks reference = grid_tracks(still);
  const Tracks scaled =
      grid_tracks([&](const Eigen::Vector2d& p) { return Eigen::Vector2d(middle + s * (p - middle)); });
  // The mean square of the offsets -20, -10, 0, 10, 20 is 200 per axis; half of the pairs moved.
  const double square = 0.5 * (s - 1) * (s - 1) * (200.0 / (200 * 200) + 200.0 / (100 * 100));
  CHECK(trajectory_nrmse(reference, scaled).value == doctest::Approx(100 * std::sqrt(square)));
  // E = (s^2 - 1) / 2 on the diagonal; the ridge perturbs F by about 1e-6.
  CHECK(strain_rmse(reference, scaled).value ==
        doctest::Approx(100 * std::sqrt(0.5 * 2) * 0.5 * (s * s - 1)).epsilon(1e-5));
}

TEST_CASE("eval: a point that is missing, not finite or not initialised counts in no frame") {
  const Tracks reference = grid_tracks(still);
  Tracks predicted = grid_tracks([](const Eigen::Vector2d& p) { return Eigen::Vector2d(p + Eigen::Vector2d(4, 0)); });
  predicted.position[1][3].x() = std::nan("");  // visible, it claims
  CHECK(trajectory_nrmse(reference, predicted).samples == 49);
  CHECK(std::isfinite(strain_rmse(reference, predicted).value));
  predicted.visible[0][7] = 0;  // hidden in frame 0: never initialised, so frame 1 does not count either
  CHECK(trajectory_nrmse(reference, predicted).samples == 47);
  CHECK_FALSE(trajectory_nrmse(Tracks{}, Tracks{}).valid);
}

TEST_CASE("eval: positions whose squares overflow are invalid") {
  const Tracks reference = grid_tracks(still);
  Tracks predicted = reference;
  predicted.position[1][12].x() = 1e300;
  CHECK_FALSE(trajectory_nrmse(reference, predicted).valid);
  CHECK_FALSE(strain_rmse(reference, predicted).valid);
}

TEST_CASE("eval: videos of different size do not compare") {
  const Tracks reference = grid_tracks(still);
  Tracks other = reference;
  other.width = 201;
  CHECK(trajectory_nrmse(reference, other).reason.find("201") != std::string::npos);
}

TEST_CASE("eval: a centre needs four of its eight neighbours in both videos") {
  const Tracks reference = grid_tracks(still);
  Tracks predicted = reference;
  // Only the corner point 0 and its neighbours 1, 5, 6 remain: three, so nothing can be measured.
  for (size_t i = 0; i < 25; ++i) predicted.visible[1][i] = i == 0 || i == 1 || i == 5 || i == 6 ? 1 : 0;
  CHECK(strain_rmse(reference, predicted).samples == 25);  // frame 0 alone
  predicted.visible[1][2] = 1;                             // a neighbour of 0 and 1, too
  CHECK(strain_rmse(reference, predicted).samples > 25);
}
