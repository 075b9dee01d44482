// Signs drawn where actions act.
#include "splat/action_signs.h"

#include <doctest/doctest.h>

#include "unit/splat/scenes.h"

using namespace physmas;
using namespace physmas::splat;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

constexpr int kSize = 200;
using Kind = ScheduleOperation::Kind;

// A cube of Gaussians around the origin, row 1, and one far below it, row 0.
struct Scene {
  Scene() {
    std::vector<Vector3f> places = {{0, 3, 0}};
    for (int i = 0; i < 125; ++i)
      places.emplace_back(0.1f * static_cast<float>(i % 5 - 2), 0.1f * static_cast<float>(i / 5 % 5 - 2),
                          0.1f * static_cast<float>(i / 25 - 2));
    gaussians = splat_test::one_gaussian(0.02f, 0.9f, 0.5f);
    gaussians.position = places;
    gaussians.rotation.resize(places.size(), gaussians.rotation[0]);
    gaussians.log_scale.resize(places.size(), gaussians.log_scale[0]);
    gaussians.opacity_logit.resize(places.size(), gaussians.opacity_logit[0]);
    gaussians.sh.resize(places.size(), gaussians.sh[0]);
    state.gaussian_row.assign(places.size(), 1);
    state.gaussian_row[0] = 0;
    op.rows = {1};
    op.start = 0.1, op.end = 0.4;
  }
  // How the picture changes: left, right, upper and lower part of it, in pixels that differ. Up is -y.
  struct Changed {
    int all = 0, left = 0, right = 0, above = 0, below = 0;
  };
  Changed draw(double time, const Vector3f& moved = Vector3f::Zero()) const {
    Candidate candidate;
    candidate.schedule = {op};
    RolloutFrame rest;
    for (const Vector3f& p : gaussians.position) {
      const Vector3f q = p + moved;
      rest.position.insert(rest.position.end(), q.data(), q.data() + 3);
      for (int k = 0; k < 9; ++k) rest.F.push_back(k % 4 == 0 ? 1 : 0);
    }
    Image picture(kSize, kSize, 3);
    const ActionSigns signs(candidate, state, gaussians, -Vector3d::UnitY());
    signs.draw(TransportedFrame(rest, state.map), time, splat_test::front_camera(kSize, kSize), picture);
    Changed changed;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const uint8_t* p = picture.at(x, y);
        if (p[0] + p[1] + p[2] == 0) continue;
        ++changed.all;
        ++(x < kSize / 2 ? changed.left : changed.right);
        ++(y < kSize / 2 ? changed.above : changed.below);
      }
    }
    return changed;
  }

  Gaussians gaussians;
  State state;  // the identity map
  ScheduleOperation op;
};

}  // namespace

TEST_CASE("signs: an arrow stands behind what is pushed and before what is dragged") {
  Scene scene;
  scene.op.velocity = {1, 0, 0};
  for (const Kind kind : {Kind::translation, Kind::impulse}) {
    scene.op.kind = kind;
    const Scene::Changed c = scene.draw(0.2);
    CHECK(c.left > 20);
    CHECK(c.right == 0);
  }
  scene.op.kind = Kind::drag_pair;
  CHECK(scene.draw(0.2).left == 0);
  CHECK(scene.draw(0.2).right > 20);
  scene.op.velocity = {0, 1, 0};  // downwards: a disc on top and an arrow above it
  scene.op.kind = Kind::top_press;
  CHECK(scene.draw(0.2).above > 20);
  CHECK(scene.draw(0.2).below == 0);
  scene.op.kind = Kind::vertical_compress;
  scene.op.velocity.setZero();
  CHECK(scene.draw(0.2).above > 20);
}

TEST_CASE("signs: they are there while the action acts, long enough to be seen, and move with what it acts on") {
  Scene scene;
  scene.op.kind = Kind::impulse;
  scene.op.velocity = {1, 0, 0};
  CHECK(scene.draw(0.09).all == 0);
  CHECK(scene.draw(0.1).all > 0);
  CHECK(scene.draw(0.39).all > 0);
  CHECK(scene.draw(0.4).all == 0);
  scene.op.end = 0.101;
  CHECK(scene.draw(0.25).all > 0);
  CHECK(scene.draw(0.27).all == 0);
  CHECK(scene.draw(0.2, {0.8f, 0, 0}).right > 20);
}

TEST_CASE("signs: every action has one, projections have none, and nothing breaks where nothing is to be seen") {
  Scene scene;
  scene.op.velocity = {0.5, 0.5, 0.2};
  scene.op.direction = Vector3d(0.3, -1, 0.2).normalized();
  scene.op.rate = 2;
  for (int kind = 0; kind < kOperationCount; ++kind) {
    CAPTURE(kind);
    scene.op.kind = static_cast<Kind>(kind);
    CHECK((scene.draw(0.2).all > 0) == scene.op.is_action());
    // Behind the camera, at the camera, and not finite.
    for (const Vector3f& away : {Vector3f(0, 0, -9), Vector3f(0, 0, -4), Vector3f(NAN, 0, 0), Vector3f(1e30f, 0, 0)})
      CHECK_NOTHROW(scene.draw(0.2, away));
  }
  scene.op.kind = Kind::impulse;
  scene.op.rows = {7};
  CHECK(scene.draw(0.2).all == 0);
}
