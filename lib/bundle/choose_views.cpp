#include "bundle/choose_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/constants.h"
#include "base/error.h"
#include "bundle/view_rig.h"

namespace physmas::bundle {
namespace {

constexpr double kDegrees = 180 / kPi;

struct Candidate {
  size_t index;
  std::array<double, 4> cosine;  // with front, right, back, left
};

std::vector<Candidate> candidates_for(const std::vector<CapturedView>& views, const Eigen::Vector3d& center,
                                      const Eigen::Matrix3d& axes) {
  // Where the front, right, back and left cameras stand.
  const std::array<Eigen::Vector3d, 4> sides = {-axes.col(1), axes.col(0), axes.col(1), -axes.col(0)};
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = views[i].camera;
    const Eigen::Vector3d q = camera.to_camera(center);
    if (!(q.z() > 0)) continue;
    const Eigen::Vector2d pixel = camera.project(q);
    if (!(pixel.x() >= 0 && pixel.x() <= camera.width && pixel.y() >= 0 && pixel.y() <= camera.height)) continue;
    const Eigen::Vector3d direction = (camera.center() - center).normalized();
    Candidate candidate = {i, {}};
    // Rounded, so that cameras that stand symmetrically tie.
    for (int side = 0; side < 4; ++side) candidate.cosine[side] = std::round(1e9 * direction.dot(sides[side])) / 1e9;
    candidates.push_back(candidate);
  }
  return candidates;
}

}  // namespace

std::array<ChosenView, 4> choose_views(const std::vector<CapturedView>& views,
                                       const std::vector<Eigen::Vector3d>& points, const std::string& up,
                                       const std::string& file, double front, int front_view) {
  const std::vector<Candidate> all = candidates_for(views, middle_of(points), scene_axes(up, front));
  if (all.size() < 4) {
    throw invalid_input({file, "",
                         fmt::format("{} of {} cameras that see the scene's centre", all.size(), views.size()),
                         "at least four", "the cameras must be in the same coordinates as the Gaussians"});
  }
  // Four different cameras need no more than the four best of each side.
  std::array<std::vector<size_t>, 4> best;
  for (int side = 0; side < 4; ++side) {
    for (size_t i = 0; i < all.size(); ++i) best[side].push_back(i);
    std::stable_sort(best[side].begin(), best[side].end(),
                     [&](size_t a, size_t b) { return all[a].cosine[side] > all[b].cosine[side]; });
    best[side].resize(4);
  }
  if (front_view >= 0) {
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const Candidate& c) { return c.index == static_cast<size_t>(front_view); });
    if (found == all.end()) {
      throw invalid_input({file, "", "a front view that does not see the scene's centre", "one that does",
                           "name another view with --front"});
    }
    best[0] = {static_cast<size_t>(found - all.begin())};
  }
  std::array<size_t, 4> chosen = {};
  double most = -5;
  for (size_t a : best[0]) {
    for (size_t b : best[1]) {
      for (size_t c : best[2]) {
        for (size_t d : best[3]) {
          if (a == b || a == c || a == d || b == c || b == d || c == d) continue;
          const double sum = all[a].cosine[0] + all[b].cosine[1] + all[c].cosine[2] + all[d].cosine[3];
          // Sums of the same cosines may differ by rounding.
          if (sum <= most + 1e-12) continue;
          most = sum;
          chosen = {a, b, c, d};
        }
      }
    }
  }
  std::array<ChosenView, 4> result;
  for (int side = 0; side < 4; ++side) {
    const Candidate& candidate = all[chosen[side]];
    result[side] = {candidate.index, std::acos(std::clamp(candidate.cosine[side], -1.0, 1.0)) * kDegrees};
  }
  return result;
}

}  // namespace physmas::bundle
