// What the screen measures in pictures, and how it compares the first with the last frame.
#include "splat/foreground.h"

#include <doctest/doctest.h>

#include <cmath>

#include "splat/quantize.h"
#include "unit/splat/scenes.h"
#include "unit/temporary_folder.h"

using namespace physmas;
using namespace physmas::splat;

namespace {

// Opaque balls around the origin, all grey.
Gaussians balls(const std::vector<Eigen::Vector3f>& places, float grey = 0.6f) {
  Gaussians g = splat_test::one_gaussian(0.1f, 0.95f, grey);
  g.position = places;
  g.rotation.resize(places.size(), g.rotation[0]);
  g.log_scale.resize(places.size(), g.log_scale[0]);
  g.opacity_logit.resize(places.size(), g.opacity_logit[0]);
  g.sh.resize(places.size(), g.sh[0]);
  return g;
}

constexpr int kWidth = 100, kHeight = 80;

// Two frames: at rest, and with every ball moved.
struct Motion {
  explicit Motion(const Gaussians& g, const std::vector<Eigen::Vector3f>& moved) : gaussians(g), renderer(gaussians) {
    scene.output_cameras = {splat_test::front_camera(kWidth, kHeight)};
    scene.run.time.frames = 2;
    state.gaussian_row.assign(g.size(), 0);
    Provenance provenance;
    provenance.tool = "test";
    RolloutWriter out(folder / "r.h5", g.size(), "elastic", provenance);
    for (int t = 0; t < 2; ++t) {
      std::vector<float> x, F, v(3 * g.size(), 0);
      for (size_t i = 0; i < g.size(); ++i) {
        const Eigen::Vector3f p = t == 0 ? g.position[i] : moved[i];
        x.insert(x.end(), p.data(), p.data() + 3);
        for (int k = 0; k < 9; ++k) F.push_back(k % 4 == 0 ? 1 : 0);
      }
      out.append(0.04 * t, x.data(), F.data(), v.data());
    }
    out.commit();
  }
  // What the video's frame t shows.
  FrameForeground picture(int t) {
    const RolloutFrames rollout(folder / "r.h5", state);
    const TransportedFrame frame = rollout.frame(t);
    const RenderedImage& image = renderer.render(scene.output_camera(t), frame.deformation(), {});
    return measure_foreground(image, quantize(image), t, scene.run.screening.dark_luminance);
  }
  std::vector<FrameForeground> endpoints() {
    const RolloutFrames rollout(folder / "r.h5", state);
    return measure_endpoints(renderer, gaussians, rollout, scene, {}, {picture(0), picture(1)});
  }

  TemporaryFolder folder;
  Gaussians gaussians;
  Renderer renderer;
  Scene scene;
  State state;  // the identity map
};

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
