// Cameras that keep what moves in the picture.
#include "splat/fitted_camera.h"

#include <doctest/doctest.h>

#include <cmath>

#include "unit/splat/scenes.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::splat;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

constexpr int kWidth = 200, kHeight = 100;

// Two small objects near the origin, the second of which moves to `ends` in the last frame.
struct Motion {
  explicit Motion(const std::vector<Vector3f>& ends) {
    gaussians = splat_test::one_gaussian(0.01f, 0.9f, 0.5f);
    std::vector<Vector3f> places = {{-0.2f, 0, 0}, {0, -0.2f, 0}, {0, 0.2f, 0}};
    places.insert(places.end(), ends.size(), {0.2f, 0, 0});
    gaussians.position = places;
    gaussians.rotation.resize(places.size(), gaussians.rotation[0]);
    gaussians.log_scale.resize(places.size(), gaussians.log_scale[0]);
    gaussians.opacity_logit.resize(places.size(), gaussians.opacity_logit[0]);
    gaussians.sh.resize(places.size(), gaussians.sh[0]);
    scene.output_cameras = {splat_test::front_camera(kWidth, kHeight)};
    scene.run.time.frames = 3;
    state.gaussian_row.assign(places.size(), 0);
    for (size_t i = 0; i < places.size(); ++i) state.gaussian_object.push_back(i < 3 ? 0 : 1);
    Provenance provenance;
    provenance.tool = "test";
    RolloutWriter out(folder / "r.h5", places.size(), "elastic", provenance);
    for (int t = 0; t < 3; ++t) {
      std::vector<float> x, F, v(3 * places.size(), 0);
      for (size_t i = 0; i < places.size(); ++i) {
        const Vector3f p = t < 2 || i < 3 ? places[i] : ends[i - 3];
        x.insert(x.end(), p.data(), p.data() + 3);
        for (int k = 0; k < 9; ++k) F.push_back(k % 4 == 0 ? 1 : 0);
        if (t == 2 && i >= 3) moved.push_back(p);
      }
      out.append(0.04 * t, x.data(), F.data(), v.data());
    }
    out.commit();
  }
  FittedCameras fit(int frames = 3) {
    const std::vector<Camera> base = base_cameras(scene, gaussians);
    FittedCameras fitted;
    const RolloutFrames rollout(folder / "r.h5", state);
    add_motion(
        gaussians, state, frames, [&](int t) { return rollout.frame(t); }, base, fitted);
    place_cameras(gaussians, base, fitted);
    return fitted;
  }

  TemporaryFolder folder;
  Gaussians gaussians;
  Scene scene;
  State state;  // the identity map
  std::vector<Vector3f> moved;
};

// How far a point is from the middle of the picture, 1 at an edge.
double off_middle(const Camera& camera, const Vector3f& p) {
  const Vector3d q = camera.to_camera(p.cast<double>());
  REQUIRE(q.z() > 0);
  const Eigen::Vector2d pixel = camera.project(q);
  return std::max(std::abs(pixel.x() / camera.width * 2 - 1), std::abs(pixel.y() / camera.height * 2 - 1));
}

bool same(const Camera& a, const Camera& b) {
  return a.world_to_camera == b.world_to_camera && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
}

}  // namespace

TEST_CASE("fit: where nothing leaves the picture the camera is the scene's own, bit for bit") {
  Motion motion({{0.5f, 0.3f, 0}});
  const FittedCameras fitted = motion.fit();
  REQUIRE(fitted.cameras.size() == 1);
  CHECK(same(fitted.cameras[0], motion.scene.output_cameras[0]));
  CHECK(fitted.distance == 1);
  CHECK(fitted.omitted.empty());
}

TEST_CASE("fit: what leaves the picture on any side is in it, the direction stays, and no step is wasted") {
  for (const Vector3f& end : {Vector3f(4, 0, 0), Vector3f(-4, 0, 0), Vector3f(0, 2, 0), Vector3f(0, -2, 0),
                              Vector3f(3, 2, 1), Vector3f(0.3f, 0.3f, -3)}) {
    CAPTURE(end.transpose());
    Motion motion({end});
    const Camera& before = motion.scene.output_cameras[0];
    const FittedCameras fitted = motion.fit();
    const Camera& after = fitted.cameras.at(0);
    CHECK(after.rotation() == before.rotation());
    CHECK(after.fx == before.fx);
    CHECK(fitted.distance >= 1);
    CHECK(fitted.omitted.empty());
    double worst = 0;
    for (const Vector3f& p : motion.gaussians.position) worst = std::max(worst, off_middle(after, p));
    for (const Vector3f& p : motion.moved) worst = std::max(worst, off_middle(after, p));
    CHECK(worst < 1 - kFreeEdge);
    CHECK(worst > 0.85);  // as near as it can be: something is at the margin
    // Frames before that do not ask for it.
    CHECK(same(motion.fit(2).cameras[0], before));
  }
}

TEST_CASE("fit: a little to the side is followed without going back") {
  Motion motion({{2.6f, 0, 0}});
  const FittedCameras fitted = motion.fit();
  CHECK(fitted.distance == 1);
  CHECK(fitted.cameras[0].center().z() == doctest::Approx(motion.scene.output_cameras[0].center().z()));
  CHECK(fitted.cameras[0].center().x() > 0.01);
  CHECK(off_middle(fitted.cameras[0], motion.moved[0]) < 1 - kFreeEdge);
}

TEST_CASE("fit: what flies off moves the camera to the bound and no further; the rest stays in the picture") {
  Motion motion({{1000, 0, 0}});
  const FittedCameras fitted = motion.fit();
  CHECK(fitted.distance == doctest::Approx(kFarthest));
  REQUIRE(fitted.omitted.size() == 1);
  for (const Vector3f& p : motion.gaussians.position) CHECK(off_middle(fitted.cameras[0], p) < 1);
}

TEST_CASE("fit: a grain of a thousand may leave, an object of its own may not") {
  std::vector<Vector3f> ends(2000, Vector3f(0.2f, 0, 0));
  ends[0] = {9, 0, 0};
  Motion grain(ends);
  CHECK(grain.fit().distance == 1);
  CHECK(Motion({{9, 0, 0}}).fit().distance > 1);
}

TEST_CASE("fit: motion adds up over candidates and rounds, and never brings the camera nearer") {
  Motion right({{9, 0, 0}}), still({{0.2f, 0, 0}});
  const std::vector<Camera> base = base_cameras(right.scene, right.gaussians);
  FittedCameras fitted = right.fit();
  const Camera alone = fitted.cameras[0];
  const RolloutFrames rollout(still.folder / "r.h5", still.state);
  add_motion(
      still.gaussians, still.state, 3, [&](int t) { return rollout.frame(t); }, base, fitted);
  place_cameras(right.gaussians, base, fitted);
  CHECK(same(fitted.cameras[0], alone));
  // As a record between the rounds.
  Provenance provenance;
  provenance.tool = "test";
  save_cameras(right.folder / "c.json", fitted, provenance);
  FittedCameras again = load_cameras(right.folder / "c.json");
  CHECK(same(again.cameras.at(0), alone));
  place_cameras(right.gaussians, base, again);
  CHECK(same(again.cameras.at(0), alone));
  CHECK(again.distance == fitted.distance);
}

TEST_CASE("fit: what is outside already at rest does not push the camera away") {
  Motion motion({{0.2f, 0, 0}});
  motion.scene.output_cameras[0].world_to_camera(0, 3) = 1.3;  // half of the scene is beyond the right edge
  CHECK(same(motion.fit().cameras[0], motion.scene.output_cameras[0]));
}

TEST_CASE("orbit: one camera per frame around the scene's middle, starting at the scene's own") {
  Motion motion({{0.2f, 0, 0}});
  motion.scene.run.placement.up = "-y";
  motion.scene.run.render.camera = RunSpecification::Render::CameraMode::orbit;
  motion.scene.run.time.frame_dt = 0.5;
  const FittedCameras fitted = motion.fit();
  REQUIRE(fitted.cameras.size() == 3);
  CHECK(same(fitted.cameras[0], motion.scene.output_cameras[0]));
  const double turn = std::acos(fitted.cameras[2].rotation().row(2).dot(fitted.cameras[0].rotation().row(2)));
  CHECK(turn * 180 / std::acos(-1) == doctest::Approx(kOrbitSpeed));
  for (const Camera& camera : fitted.cameras) {
    CHECK(camera.center().y() == doctest::Approx(0));
    CHECK(camera.center().norm() == doctest::Approx(4).epsilon(0.06));
    for (const Vector3f& p : motion.gaussians.position) CHECK(off_middle(camera, p) < 1);
  }
  // With y down, the right of a camera that looks along z is +x.
  CHECK(fitted.cameras[1].center().x() > 0.1);
  motion.scene.output_cameras.assign(3, motion.scene.output_cameras[0]);
  CHECK_THROWS(base_cameras(motion.scene, motion.gaussians));
}
