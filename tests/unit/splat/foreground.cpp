// What the screen measures in pictures, and how it compares the first with the last frame.
#include "splat/foreground.h"

#include <doctest/doctest.h>

#include <cmath>

#include "splat/quantize.h"
#include "unit/splat/motion.h"

using namespace physmas;
using namespace physmas::splat;
using splat_test::balls;
using splat_test::kHeight;
using splat_test::kWidth;
using splat_test::Motion;

namespace {

// A ball in the middle of the picture, and one moved by `dx` to the right or `dy` up.
Motion one_ball(float dx, float dy) {
  return Motion(balls({{0, 0, 0}}), {{dx, dy, 0}});
}

}  // namespace

TEST_CASE("splat: the foreground's box and its dark share") {
  RenderedImage image;
  image.width = 5;
  image.height = 4;
  image.alpha.assign(20, 0.0f);
  Image quantized(5, 4, 3);
  const auto paint = [&](int x, int y, float alpha, uint8_t grey) {
    image.alpha[static_cast<size_t>(5) * y + x] = alpha;
    for (int k = 0; k < 3; ++k) quantized.pixels[3 * (static_cast<size_t>(5) * y + x) + k] = grey;
  };
  CHECK_FALSE(measure_foreground(image, quantized, 7, 0.08).present);
  paint(0, 0, 0.49f, 0);  // a fringe
  paint(1, 2, 0.5f, 0);
  paint(3, 2, 1, 255);
  paint(2, 3, 1, 21);  // 21/255 > 0.08
  paint(1, 3, 1, 20);
  const FrameForeground found = measure_foreground(image, quantized, 7, 0.08);
  CHECK(found.frame == 7);
  CHECK(found.present);
  CHECK(found.x0 == 1);
  CHECK(found.y0 == 2);
  CHECK(found.x1 == 4);
  CHECK(found.y1 == 4);
  CHECK(found.area() == 6);
  CHECK(found.dark_ratio == 0.5);
}

TEST_CASE("splat: dark is a foreground pixel whose Rec. 709 luminance is below the limit") {
  RenderedImage image;
  image.width = 5;
  image.height = 1;
  image.alpha = {1, 1, 1, 1, 0};
  Image quantized(5, 1, 3);
  quantized.pixels = {255, 0, 0, 0, 255, 0, 0, 0, 255, 51, 51, 51, 0, 0, 0};  // 0.2126, 0.7152, 0.0722, 0.2
  const auto dark = [&](double limit) { return measure_foreground(image, quantized, 0, limit).dark_ratio; };
  CHECK(dark(0.05) == 0);
  CHECK(dark(0.1) == 0.25);
  CHECK(dark(0.21) == 0.5);
  CHECK(dark(0.22) == 0.75);
  CHECK(dark(0.8) == 1);
}

TEST_CASE("splat: endpoints are the pictures where one camera sees everything") {
  CHECK(one_ball(0.3f, 0.2f).endpoints().empty());
}

TEST_CASE("splat: what leaves the picture keeps its box on the plane") {
  Motion inside = one_ball(0, 0);
  const FrameForeground rest = inside.picture(0);
  REQUIRE(rest.present);
  for (const auto& [dx, dy] :
       {std::pair(1.6f, 0.0f), std::pair(-1.6f, 0.0f), std::pair(0.0f, 1.25f), std::pair(4.0f, -3.0f)}) {
    Motion motion = one_ball(dx, dy);
    const FrameForeground cut = motion.picture(1);
    const std::vector<FrameForeground> found = motion.endpoints();
    REQUIRE(found.size() == 2);
    CHECK(found[0].frame == 0);
    CHECK(found[0].x0 == rest.x0);
    CHECK(found[0].area() == rest.area());
    CHECK(found[1].frame == 1);
    REQUIRE(found[1].present);
    CHECK(cut.area() < 0.8 * rest.area());
    // The same ball, seen at an angle: perspective stretches it a little.
    CHECK(found[1].area() > 0.75 * rest.area());
    CHECK(found[1].area() < 2.6 * rest.area());
    // Its middle is where the camera projects it.
    const Camera& camera = motion.scene.output_camera(0);
    const Eigen::Vector2d u = camera.project(camera.to_camera(Eigen::Vector3d(dx, dy, 0)));
    CHECK(std::abs(0.5 * (found[1].x0 + found[1].x1) - u.x()) < 1.5);
    CHECK(std::abs(0.5 * (found[1].y0 + found[1].y1) - u.y()) < 1.5);
    CHECK(found[1].dark_ratio == rest.dark_ratio);
  }
}

TEST_CASE("splat: a part that leaves the picture widens the box although the rest touches no edge") {
  Motion motion(balls({{-0.2f, 0, 0}, {0.2f, 0, 0}}), {{-0.2f, 0, 0}, {3, 0, 0}});
  const FrameForeground cut = motion.picture(1);
  CHECK(cut.x1 < kWidth);
  CHECK(cut.area() < motion.picture(0).area());
  const std::vector<FrameForeground> found = motion.endpoints();
  REQUIRE(found.size() == 2);
  CHECK(found[1].x0 == cut.x0);
  CHECK(found[1].x1 > kWidth);
}

TEST_CASE("splat: on a camera path both endpoints are measured in the first camera") {
  Motion motion = one_ball(0.2f, 0);
  const FrameForeground still = motion.picture(1);                                      // in the only camera
  motion.scene.output_cameras.push_back(splat_test::front_camera(kWidth, kHeight, 2));  // twice as near
  const FrameForeground shown = motion.picture(1);
  CHECK(shown.area() > 3 * still.area());
  const std::vector<FrameForeground> found = motion.endpoints();
  REQUIRE(found.size() == 2);
  CHECK(found[1].x0 == still.x0);
  CHECK(found[1].x1 == still.x1);
  CHECK(found[1].y0 == still.y0);
  CHECK(found[1].y1 == still.y1);
}

TEST_CASE("splat: endpoints need both pictures, and a scene far wider than its picture is cut on the plane") {
  Motion motion = one_ball(1.6f, 0);
  const RolloutFrames rollout(motion.folder / "r.h5", motion.state);
  CHECK(measure_endpoints(motion.renderer, motion.gaussians, rollout, motion.scene, {}, {motion.picture(0)}).empty());
  CHECK(measure_endpoints(motion.renderer, motion.gaussians, rollout, motion.scene, {}, {motion.picture(1)}).empty());

  Motion wide(balls({{0, 0, 0}, {0.1f, 0, 0}}), {{-60, 0, 0}, {60, 0, 0}});  // both beyond sixteen pictures
  const std::vector<FrameForeground> found = wide.endpoints();
  CHECK(found.empty());  // neither the picture nor the plane shows anything
  CHECK_FALSE(wide.picture(1).present);
}

TEST_CASE("splat: what went behind the camera counts where it left the view") {
  // The camera stands at z = -4 and looks along z. Of two balls one flies past it on its right.
  Motion motion(balls({{-0.2f, 0, 0}, {0.2f, 0, 0}}), {{-0.2f, 0, 0}, {0.4f, 0, -5}});
  const std::vector<FrameForeground> found = motion.endpoints();
  REQUIRE(found.size() == 2);
  CHECK(found[0].behind == 0);
  CHECK(found[1].behind == 1);
  CHECK(found[1].x0 == motion.picture(1).x0);
  CHECK(found[1].x1 > kWidth);
  // Alone, too: a picture that shows nothing is no excuse.
  Motion alone(balls({{0, 0, 0}}), {{0.4f, 0, -5}});
  CHECK_FALSE(alone.picture(1).present);
  REQUIRE(alone.endpoints().size() == 2);
  CHECK(alone.endpoints()[1].present);
  CHECK(alone.endpoints()[1].x0 > kWidth);
  // What was behind it at rest was never seen, and a stray one among thousands says nothing.
  CHECK(Motion(balls({{0, 0, 0}, {0.4f, 0, -5}}), {{0, 0, 0}, {0.4f, 0, -6}}).endpoints().empty());
  std::vector<Eigen::Vector3f> many(1500, {0, 0, 0}), moved = many;
  moved[7] = {0.4f, 0, -5};
  CHECK(Motion(balls(many), moved).endpoints().empty());
  moved[8] = moved[7];
  CHECK(Motion(balls(many), moved).endpoints().size() == 2);
}
