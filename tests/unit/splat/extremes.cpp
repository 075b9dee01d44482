#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "splat/renderer.h"
#include "unit/splat/checks.h"
#include "unit/splat/scenes.h"

using namespace physmas;
using namespace physmas::splat;
using namespace physmas::splat_test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

TEST_CASE("splat: within one 8-bit level of the plain renderer over every background") {
  std::mt19937 random(4);
  for (const Eigen::Vector3f& background :
       {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(1, 0, 0.37f)}) {
    for (int degree = 0; degree <= 3; ++degree) {
      Gaussians g = random_scene(250, degree, random());
      std::vector<RowMatrix3f> F = random_deformations(g.size(), random());
      for (size_t i = 0; i < g.size(); ++i) {
        if (i % 4 == 0) F[i].col(2) = -F[i].col(2);  // mirrored
        if (i % 4 == 1) F[i].col(1).setZero();       // flat
        if (i % 5 == 0) g.log_scale[i] = {2.5f, -7, -7};
        if (i % 7 == 0) g.opacity_logit[i] = i % 2 == 0 ? 40.0f : -40.0f;  // 1 and 0
      }
      RenderOptions options;
      options.background = background;
      Deformation deformation;
      deformation.F = F.data();
      // From outside, from within, and over the horizon of a wide lens.
      for (const Camera& camera : {look_at({0.2, -0.3, -3}, {0, 0, 0}, {0, -1, 0}, 0.7, 81, 60),
                                   look_at({0, 0.1, 0}, {0.4, 0, 1}, {0, -1, 0}, 1.2, 81, 60),
                                   look_at({0, -0.8, -1}, {0, -0.8, 1}, {0, -1, 0}, 2.2, 81, 60)}) {
        Renderer renderer(g);
        const RenderedImage& image = renderer.render(camera, deformation, options);
        const ReferenceImage reference =
            reference_render(g, camera, F.data(), background.cast<double>(), renderer.default_near());
        CHECK(levels_off(image, reference) < 0.5);
      }
    }
  }
}

TEST_CASE("splat: opacity 0 leaves no trace, opacity 1 lets a hundredth through") {
  Gaussians g = one_gaussian(0.2f, 0.5f, 1);
  g.resize(2, 0);
  g.log_scale[1] = g.log_scale[0];
  g.position[1].z() = 1;
  g.opacity_logit = {1000, 1000};
  g.sh[1].setConstant(-0.5f / kShC0);
  const Camera camera = front_camera(33, 33);
  const int center = 16 * 33 + 16;
  Renderer opaque(g);
  const RenderedImage& image = opaque.render(camera);
  CHECK(image.rgb[3 * center] == doctest::Approx(0.99f));
  // Two of them would leave a transmittance just below 1e-4, so the second is not drawn.
  CHECK(image.alpha[center] == doctest::Approx(0.99f));
  g.opacity_logit[0] = -1000;
  Renderer clear(g);
  CHECK(clear.render(camera).rgb[3 * center] == 0);
  CHECK(clear.stats().drawn == 1);
}

TEST_CASE("splat: frame after frame equals rendering everything anew, bit for bit") {
  const Gaussians g = random_scene(1500, 3, 111);
  std::vector<int32_t> labels(g.size());
  for (size_t i = 0; i < g.size(); ++i) labels[i] = static_cast<int32_t>(i % 5);
  RenderOptions options;
  options.depth = options.label = true;
  options.labels = labels.data();
  std::mt19937 random(112);
  std::normal_distribution<float> normal;
  std::vector<Eigen::Vector3f> position = g.position;
  std::vector<RowMatrix3f> F(g.size(), RowMatrix3f::Identity());
  Deformation deformation;
  deformation.position = position.data();
  deformation.F = F.data();
  Renderer renderer(g);
  Camera camera = front_camera(120, 90);
  size_t moved = g.size();
  for (int frame = 0; frame < 8; ++frame) {
    if (frame == 5) camera = look_at({1, -1, -3}, {0, 0, 0}, {0, -1, 0}, 0.6, 120, 90);
    if (frame == 6) options.max_sh_degree = 1;
    const RenderedImage kept = renderer.render(camera, deformation, options);
    CHECK(renderer.stats().reprojected == (frame == 5 || frame == 6 ? g.size() : moved));
    Renderer fresh(g);
    CHECK(same_pixels(kept, fresh.render(camera, deformation, options)));
    CHECK(renderer.stats().skipped == fresh.stats().skipped);
    // A part moves, some of it out of the image, to infinity, and back from there.
    moved = 0;
    for (size_t i = frame; i < g.size(); i += 7, ++moved) {
      position[i] = g.position[i] + 0.3f * Eigen::Vector3f(normal(random), normal(random), normal(random));
      F[i](0, 1) = normal(random);
      if (i % 31 == 0) F[i](2, 2) = frame % 2 == 0 ? kNan : 1.0f + normal(random);
      if (i % 37 == 0) position[i].z() = -100;
    }
  }
}

TEST_CASE("splat: a million opaque Gaussians in one tile end early") {
  Gaussians g;
  g.resize(1000000, 0);
  for (size_t i = 0; i < g.size(); ++i) {
    g.position[i].z() = 1e-6f * static_cast<float>(i);
    g.log_scale[i].setConstant(2);
    g.opacity_logit[i] = 3;
    g.sh[i].setConstant(i < 10 ? 1.0f : -1.0f);
  }
  RenderOptions options;
  options.near = 0.1;
  options.threads = 1;
  Renderer renderer(g);
  const RenderedImage& image = renderer.render(front_camera(16, 16), {}, options);
  // A handful of them would leave less than 1e-4, and none leaves less than a twenty-second: blending ends above 22e-4.
  for (float a : image.alpha) CHECK(a > 1 - 22e-4f);
  for (float v : image.rgb) CHECK(v == doctest::Approx(0.5f + kShC0).epsilon(22e-4));
  CHECK(renderer.stats().drawn == g.size());
}
