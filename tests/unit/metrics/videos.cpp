// From pictures to numbers: videos whose motion is known, tracked by optical flow inside known masks.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "metrics/video_tracks.h"
#include "splat/video.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::metrics;

namespace {

constexpr int kSize = 192, kFrames = 5;
const Eigen::Vector2d kMiddle(80, 80);

// x -> kMiddle + F (x - kMiddle) + shift, pixels.
struct Motion {
  Eigen::Matrix2d F = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Vector2d operator()(const Eigen::Vector2d& x) const { return kMiddle + F * (x - kMiddle) + shift; }
  Eigen::Vector2d back(const Eigen::Vector2d& x) const { return kMiddle + F.inverse() * (x - kMiddle - shift); }
};

bool in_target(const Eigen::Vector2d& rest) {
  return (rest - kMiddle).cwiseAbs().maxCoeff() < 50;
}

// Smooth noise that repeats nowhere: values 40..220 on a lattice of 6 pixels, interpolated smoothly.
double texture(const Eigen::Vector2d& rest) {
  static const std::vector<double> lattice = [] {
    std::mt19937 random(1);
    std::vector<double> values(40 * 40);
    for (double& v : values) v = 40 + random() % 181;
    return values;
  }();
  const Eigen::Vector2d at = (rest - kMiddle) / 6 + Eigen::Vector2d(20, 20);
  const int i = std::clamp(static_cast<int>(at.x()), 0, 38), j = std::clamp(static_cast<int>(at.y()), 0, 38);
  const auto smooth = [](double x) { return std::clamp(x * x * (3 - 2 * x), 0.0, 1.0); };
  const double u = smooth(at.x() - i), v = smooth(at.y() - j);
  const double* row = &lattice[40 * j + i];
  return (1 - v) * ((1 - u) * row[0] + u * row[1]) + v * ((1 - u) * row[40] + u * row[41]);
}

struct Film {
  std::string path;
  std::vector<Image> masks;
};

// A textured square of 100 pixels that moves by motion(t); covered(x, t): hidden by something grey in front.
Film film(const std::string& path, const std::function<Motion(int)>& motion,
          const std::function<bool(const Eigen::Vector2d&, int)>& covered = nullptr) {
  Film film = {path, {}};
  splat::VideoWriter writer(path, kSize, kSize, 25);
  for (int t = 0; t < kFrames; ++t) {
    Image picture(kSize, kSize, 3), mask(kSize, kSize, 1);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const Eigen::Vector2d place(x + 0.5, y + 0.5), rest = motion(t).back(place);
        const bool seen = in_target(rest) && !(covered && covered(place, t));
        const double c = texture(rest);
        for (int k = 0; k < 3; ++k) picture.at(x, y)[k] = seen ? static_cast<uint8_t>(c) : 20;
        *mask.at(x, y) = seen ? 255 : 0;
      }
    }
    writer.write(picture);
    film.masks.push_back(mask);
  }
  writer.finish();
  return film;
}

struct Errors {
  Measurement trajectory, area, strain;
};

// As pm-eval flow measures.
Errors compare(const Film& reference, const Film& measured) {
  const std::vector<QueryPixel> queries = query_pixels(reference.masks[0]);
  Tracks expected = track_by_flow(reference.path, queries), found = track_by_flow(measured.path, queries);
  restrict_to_masks(expected, reference.masks, reference.path);
  restrict_to_masks(found, measured.masks, measured.path);
  return {trajectory_nrmse(expected, found), area_log_rmse(mask_areas(reference.masks), mask_areas(measured.masks)),
          strain_rmse(expected, found)};
}

// What trajectory_nrmse is for tracks without error, 100 sqrt(mean |motion(x) - x|^2 / size^2) over all queries.
double exact_trajectory(const Film& reference, const std::function<Motion(int)>& motion) {
  double sum = 0;
  long pairs = 0;
  for (int t = 0; t < kFrames; ++t) {
    for (const QueryPixel& q : query_pixels(reference.masks[0])) {
      const Eigen::Vector2d x(q.x + 0.5, q.y + 0.5);
      sum += (motion(t)(x) - x).squaredNorm() / (double(kSize) * kSize);
      ++pairs;
    }
  }
  return 100 * std::sqrt(sum / static_cast<double>(pairs));
}

// 100 sqrt(mean over frames ||E||_F^2), E = (F^T F - I) / 2.
double exact_strain(const std::function<Motion(int)>& motion) {
  double sum = 0;
  for (int t = 0; t < kFrames; ++t)
    sum += (0.5 * (motion(t).F.transpose() * motion(t).F - Eigen::Matrix2d::Identity())).squaredNorm() / kFrames;
  return 100 * std::sqrt(sum);
}

Motion still(int) {
  return {};
}

// Lossy video and sub-pixel flow are a tenth of a pixel off or so: 0.05 for an image of 192 pixels.
constexpr double kTrack = 0.1;
// Neighbours are 12 pixels apart, so that a tenth of a pixel is a strain of about 0.008.
constexpr double kStrain = 1;

}  // namespace

TEST_CASE("eval: a video that is shifted has the shift as its error, and neither area nor strain") {
  const TemporaryFolder folder;
  const auto shifted = [](int t) {
    Motion m;
    m.shift = Eigen::Vector2d(2.5 * t, 1.0 * t);
    return m;
  };
  const Film reference = film(folder / "a.mp4", still);
  const Errors errors = compare(reference, film(folder / "b.mp4", shifted));
  CHECK(std::fabs(errors.trajectory.value - exact_trajectory(reference, shifted)) < kTrack);
  CHECK(errors.trajectory.samples == kFrames * static_cast<long>(query_pixels(reference.masks[0]).size()));
  CHECK(errors.area.value < 1.5);  // half pixels at the rim of 100: at most 1 %
  CHECK(errors.strain.value < kStrain);
}

TEST_CASE("eval: a video of a growing object has its scale in track, area and strain") {
  const TemporaryFolder folder;
  const auto growing = [](int t) {
    Motion m;
    m.F *= 1 + 0.04 * t;
    return m;
  };
  const Film reference = film(folder / "a.mp4", still);
  const Errors errors = compare(reference, film(folder / "b.mp4", growing));
  CHECK(std::fabs(errors.trajectory.value - exact_trajectory(reference, growing)) < kTrack);
  CHECK(std::fabs(errors.strain.value - exact_strain(growing)) < kStrain);
  double square = 0;
  for (int t = 0; t < kFrames; ++t) square += std::pow(2 * std::log(1 + 0.04 * t), 2) / kFrames;
  CHECK(std::fabs(errors.area.value - 100 * std::sqrt(square)) < 1.5);
}

TEST_CASE("eval: a video of a sheared object has its closed-form strain, and keeps its area") {
  const TemporaryFolder folder;
  const auto sheared = [](int t) {
    Motion m;
    m.F(0, 1) = 0.05 * t;
    return m;
  };
  const Film reference = film(folder / "a.mp4", still);
  const Errors errors = compare(reference, film(folder / "b.mp4", sheared));
  CHECK(std::fabs(errors.trajectory.value - exact_trajectory(reference, sheared)) < kTrack);
  CHECK(std::fabs(errors.strain.value - exact_strain(sheared)) < kStrain);
  CHECK(errors.area.value < 1.5);
}

TEST_CASE("eval: what is covered counts in neither video, and a target that is gone has no points but an area") {
  const TemporaryFolder folder;
  // From frame 2 on something covers the lowest quarter, in the last frame everything.
  const auto cover = [](const Eigen::Vector2d& x, int t) {
    return (t >= 2 && x.y() > kMiddle.y() + 25) || t == kFrames - 1;
  };
  const Film reference = film(folder / "a.mp4", still);
  const Errors errors = compare(reference, film(folder / "b.mp4", still, cover));
  // Six of eight rows of queries are left; flow may lose what is near the cover with it.
  const long all = static_cast<long>(query_pixels(reference.masks[0]).size());
  CHECK(all == 64);
  CHECK(errors.trajectory.samples <= 2 * all + 2 * all * 6 / 8);
  CHECK(errors.trajectory.samples >= 2 * all + 2 * all * 3 / 8);
  CHECK(errors.trajectory.value < kTrack);  // nothing moves
  CHECK(errors.strain.value < kStrain);
  const double part = std::log(7501) - std::log(10001), gone = -std::log(10001);
  CHECK(errors.area.value == doctest::Approx(100 * std::sqrt((2 * part * part + gone * gone) / kFrames)));
}
