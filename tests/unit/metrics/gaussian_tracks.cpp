// Exact tracks of projected Gaussians on objects whose visibility is known.
#include "metrics/gaussian_tracks.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/constants.h"
#include "splat/dominant.h"
#include "splat/renderer.h"
#include "unit/splat/scenes.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::metrics;

namespace {

constexpr double kDistance = 5;                       // of the camera from the middle, scene units
constexpr float kSigma = 0.03f, kThickness = 0.003f;  // of the discs, standard deviations

// Opaque discs evenly over a unit sphere around the origin (a Fibonacci lattice), flat on its surface.
Gaussians sphere(size_t n) {
  Gaussians g = splat_test::one_gaussian(kSigma, 0.95f, 0.5f);
  g.position.clear();
  g.rotation.clear();
  g.log_scale.assign(n, {std::log(kSigma), std::log(kSigma), std::log(kThickness)});
  for (size_t i = 0; i < n; ++i) {
    const double y = 1 - (2.0 * i + 1) / n, r = std::sqrt(1 - y * y), a = i * kPi * (3 - std::sqrt(5.0));
    g.position.emplace_back(r * std::cos(a), y, r * std::sin(a));
    const Eigen::Quaternionf q = Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), g.position.back());
    g.rotation.push_back({q.w(), q.x(), q.y(), q.z()});
  }
  g.opacity_logit.resize(n, g.opacity_logit[0]);
  g.sh.resize(n, g.sh[0]);
  return g;
}

// A rollout in which every Gaussian of `rest` is where `motion` puts it, with that map as its F.
void write_rollout(const std::string& path, const Gaussians& rest, const std::vector<Eigen::Affine3f>& motion) {
  Provenance provenance;
  provenance.tool = "test";
  RolloutWriter out(path, rest.size(), "elastic", provenance);
  for (size_t t = 0; t < motion.size(); ++t) {
    std::vector<float> x, F, v(3 * rest.size(), 0);
    for (const Eigen::Vector3f& p : rest.position) {
      const Eigen::Vector3f moved = motion[t] * p;
      const splat::RowMatrix3f linear = motion[t].linear();
      x.insert(x.end(), moved.data(), moved.data() + 3);
      F.insert(F.end(), linear.data(), linear.data() + 9);
    }
    out.append(0.04 * t, x.data(), F.data(), v.data());
  }
  out.commit();
}

struct SphereScene {
  explicit SphereScene(size_t n) : gaussians(sphere(n)) {
    scene.output_cameras = {splat_test::front_camera(200, 200, kDistance)};
    state.gaussian_row.assign(n, 0);
  }
  TargetMotion track(const std::vector<Eigen::Affine3f>& motion) {
    write_rollout(folder / "r.h5", gaussians, motion);
    const splat::RolloutFrames rollout(folder / "r.h5", state);
    const std::vector<uint8_t> target(gaussians.size(), 1);
    queries = choose_queries(scene, gaussians, rollout, target);
    return track_target(scene, gaussians, rollout, target, queries);
  }
  TemporaryFolder folder;
  Gaussians gaussians;
  Scene scene;
  State state;  // the identity map
  std::vector<int> queries;
};

}  // namespace

TEST_CASE("eval: points of a turning sphere are visible until they turn to its back") {
  SphereScene s(5000);
  std::vector<Eigen::Affine3f> motion;
  for (int t = 0; t <= 8; ++t)
    motion.emplace_back(Eigen::AngleAxisf(static_cast<float>(t * kPi / 8), Eigen::Vector3f::UnitY()));
  const TargetMotion found = s.track(motion);
  REQUIRE(s.queries.size() > 40);
  const Eigen::Vector3f eye(0, 0, -static_cast<float>(kDistance));
  size_t sure = 0;
  for (size_t t = 0; t < motion.size(); ++t) {
    for (size_t k = 0; k < s.queries.size(); ++k) {
      // On a unit sphere the normal is the position. A point whose normal has the cosine c to the direction of the eye
      // lies 2 c behind the surface that hides it when c < 0, and at the surface when c > 0.
      const Eigen::Vector3f p = motion[t] * s.gaussians.position[s.queries[k]];
      const float c = p.dot((eye - p).normalized());
      // The tolerance is at most 0.09 along the ray and 1/400 of the size of about 3. At 0.2 front and back are 0.4
      // apart.
      if (std::fabs(c) < 0.2) continue;
      CHECK(int(found.tracks.visible[t][k]) == (c > 0 ? 1 : 0));
      ++sure;
    }
  }
  CHECK(sure > 0.6 * motion.size() * s.queries.size());
  // After half a turn the whole front is at the back, although every point is still inside the silhouette.
  CHECK(std::count(found.tracks.visible[8].begin(), found.tracks.visible[8].end(), 1) < 0.05 * s.queries.size());
  for (const long area : found.areas) CHECK(std::abs(area - found.areas[0]) < 0.02 * found.areas[0]);
}

TEST_CASE("eval: a point keeps its place on an object that only moves, stretches or comes nearer") {
  SphereScene s(5000);
  Eigen::Affine3f stretched(Eigen::Scaling(1.3f, 0.8f, 1.1f)), nearer(Eigen::Translation3f(0.3f, 0.1f, -1));
  const TargetMotion found = s.track({Eigen::Affine3f::Identity(), stretched, nearer});
  // What frame 0 shows near the middle stays in sight: its normals stay towards the camera.
  size_t middle = 0;
  for (size_t k = 0; k < s.queries.size(); ++k) {
    if (s.gaussians.position[s.queries[k]].z() > -0.7) continue;
    ++middle;
    for (size_t t = 0; t < 3; ++t) CHECK(found.tracks.visible[t][k] == 1);
  }
  CHECK(middle > 30);
}

TEST_CASE("splat: the Gaussian that a pixel shows is the one of the renderer's label image") {
  const Gaussians g = splat_test::random_scene(300, 0, 5);
  const std::vector<splat::RowMatrix3f> F = splat_test::random_deformations(g.size(), 6);
  splat::Deformation deformation;
  deformation.position = g.position.data();
  deformation.F = F.data();
  std::vector<int32_t> index(g.size());
  std::iota(index.begin(), index.end(), 0);
  splat::RenderOptions options;
  options.labels = index.data();
  options.label = true;
  splat::Renderer renderer(g);
  const Camera camera = splat_test::front_camera(40, 30);
  const splat::RenderedImage& image = renderer.render(camera, deformation, options);
  std::vector<Eigen::Vector2i> pixels;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) pixels.emplace_back(x, y);
  }
  const std::vector<int> found = splat::dominant_gaussians(g, deformation, camera, renderer.default_near(), pixels);
  CHECK(std::equal(found.begin(), found.end(), image.label.begin(), image.label.end()));
  CHECK(std::count(found.begin(), found.end(), -1) < 1200);
}
