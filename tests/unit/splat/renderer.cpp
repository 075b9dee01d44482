#include "splat/renderer.h"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "unit/splat/checks.h"
#include "unit/splat/reference.h"
#include "unit/splat/scenes.h"

using namespace physmas;
using namespace physmas::splat;
using namespace physmas::splat_test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

TEST_CASE("splat: the fast renderer agrees with the plain one") {
  for (int degree = 0; degree <= 3; ++degree) {
    const Gaussians g = random_scene(400, degree, 10 + degree);
    const std::vector<RowMatrix3f> F = random_deformations(g.size(), 20 + degree);
    Renderer renderer(g);
    // From outside, close up, and from within.
    for (double distance : {4.0, 1.5, 0.1}) {
      const Camera camera = look_at({0.3, -0.2, -distance}, {0, 0, 0.5}, {0, -1, 0}, 0.8, 101, 75);
      for (const RowMatrix3f* f : {static_cast<const RowMatrix3f*>(nullptr), F.data()}) {
        RenderOptions options;
        options.background = {0.2f, 0.5f, 0.9f};
        options.depth = true;
        Deformation deformation;
        deformation.F = f;
        const RenderedImage& image = renderer.render(camera, deformation, options);
        const ReferenceImage reference =
            reference_render(g, camera, f, options.background.cast<double>(), renderer.default_near());
        CHECK(levels_off(image, reference) < 0.5);
        double depth_off = 0;
        for (size_t p = 0; p < reference.depth.size(); ++p) {
          if (!reference.tie[p]) depth_off = std::max(depth_off, std::abs(image.depth[p] - reference.depth[p]));
        }
        CHECK(depth_off < 2e-3);
      }
    }
  }
}

TEST_CASE("splat: long thin splats far outside the image stay exact") {
  Gaussians g = random_scene(60, 0, 5);
  for (auto& s : g.log_scale) s = {3.0f, -7.0f, -7.0f};
  for (auto& o : g.opacity_logit) o = 2;
  for (auto& p : g.position) p *= 2;
  Renderer renderer(g);
  const Camera camera = front_camera(160, 120);
  const RenderedImage& image = renderer.render(camera);
  CHECK(levels_off(image, reference_render(g, camera, nullptr, Eigen::Vector3d::Zero(), renderer.default_near())) <
        0.5);
}

TEST_CASE("splat: one Gaussian lies where the camera model puts it and has the analytic profile") {
  const Gaussians g = one_gaussian(0.05f, 0.8f, 0.75f);
  Camera camera = front_camera(64, 64);
  camera.cx = 20.5, camera.cy = 40.5;
  Renderer renderer(g);
  const RenderedImage& image = renderer.render(camera);
  const double variance = std::pow(0.05 * camera.fx / 4, 2) + 0.3;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double r2 = (x - 20) * (x - 20) + (y - 40) * (y - 40);
      const double alpha = 0.8 * std::exp(-0.5 * r2 / variance);
      const float got = image.alpha[y * 64 + x];
      if (alpha > 1.001 / 255) CHECK(got == doctest::Approx(alpha).epsilon(1e-4));
      if (alpha < 0.999 / 255) CHECK(got == 0);
      CHECK(image.rgb[3 * (y * 64 + x)] == doctest::Approx(0.75 * got).epsilon(1e-4));
    }
  }
}

TEST_CASE("splat: turning scene and camera together changes nothing") {
  const Gaussians g = random_scene(300, 3, 31);
  const Camera camera = front_camera(96, 96);
  Renderer renderer(g);
  const RenderedImage still = renderer.render(camera);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  std::vector<Eigen::Vector3f> position;
  for (const auto& p : g.position) position.push_back((R * p.cast<double>()).cast<float>());
  const std::vector<RowMatrix3f> F(g.size(), R.cast<float>());
  Camera turned = camera;
  turned.world_to_camera.topLeftCorner<3, 3>() = camera.rotation() * R.transpose();
  Deformation deformation;
  deformation.position = position.data();
  deformation.F = F.data();
  const RenderedImage& moved = renderer.render(turned, deformation);
  size_t different = 0;
  for (size_t k = 0; k < still.rgb.size(); ++k) different += std::abs(still.rgb[k] - moved.rgb[k]) > 1 / 255.0;
  CHECK(different < still.rgb.size() / 1000);
}

TEST_CASE("splat: the bytes depend neither on threads, nor on the memory cap, nor on earlier frames") {
  const Gaussians g = random_scene(2000, 1, 41);
  std::vector<int32_t> labels(g.size());
  for (size_t i = 0; i < g.size(); ++i) labels[i] = static_cast<int32_t>(i % 7) - 1;
  const Camera camera = front_camera(201, 133);
  RenderOptions options;
  options.depth = options.label = true;
  options.labels = labels.data();
  options.threads = 1;
  Renderer renderer(g);
  const RenderedImage one = renderer.render(camera, {}, options);
  for (int threads : {2, 3, 8}) {
    options.threads = threads;
    CHECK(same_pixels(Renderer(g).render(camera, {}, options), one));
  }
  options.max_pairs = 50;
  CHECK(same_pixels(renderer.render(camera, {}, options), one));
  CHECK(renderer.stats().reprojected == 0);
  const std::vector<RowMatrix3f> F = random_deformations(g.size(), 42);
  Deformation deformation;
  deformation.F = F.data();
  renderer.render(front_camera(50, 60), deformation, options);
  CHECK(renderer.stats().reprojected == g.size());
  CHECK(same_pixels(renderer.render(camera, {}, options), one));
}

TEST_CASE("splat: only what moved is projected again") {
  const Gaussians g = random_scene(500, 3, 51);
  const Camera camera = front_camera(64, 64);
  Renderer renderer(g);
  renderer.render(camera);
  std::vector<Eigen::Vector3f> position = g.position;
  position[17].x() += 0.3f;
  Deformation deformation;
  deformation.position = position.data();
  const RenderedImage moved = renderer.render(camera, deformation);
  CHECK(renderer.stats().reprojected == 1);
  CHECK(same_pixels(Renderer(g).render(camera, deformation), moved));
}

TEST_CASE("splat: labels, depth and shown") {
  Gaussians g = one_gaussian(0.1f, 0.95f, 0.5f);
  g.resize(3, 0);
  g.log_scale[1] = g.log_scale[2] = g.log_scale[0];
  g.opacity_logit[1] = g.opacity_logit[2] = g.opacity_logit[0];
  g.position[1] = {0.6f, 0, 1};
  g.position[2] = {0, 0, 1};  // behind the first
  const int32_t labels[] = {4, -1, 2};
  RenderOptions options;
  options.depth = options.label = true;
  options.labels = labels;
  Renderer renderer(g);
  const Camera camera = front_camera(65, 65);
  const RenderedImage image = renderer.render(camera, {}, options);
  const int center = 32 * 65 + 32;
  CHECK(image.label[center] == 4);
  CHECK(image.label[0] == -1);
  CHECK(image.depth[0] == 0);
  CHECK(image.depth[center] == doctest::Approx(4).epsilon(0.02));
  const Eigen::Vector2d second = camera.project(camera.to_camera({0.6, 0, 1}));
  CHECK(image.label[32 * 65 + static_cast<int>(second.x())] == -1);
  CHECK(image.depth[32 * 65 + static_cast<int>(second.x())] == doctest::Approx(5));
  const uint8_t shown[] = {0, 1, 1};
  options.shown = shown;
  CHECK(renderer.render(camera, {}, options).label[center] == 2);
}

TEST_CASE("splat: colours are cut below and not above, and the background shines through") {
  Gaussians g = one_gaussian(0.3f, 0.5f, 0.5f);
  g.sh[0] = {(3 - 0.5f) / 0.28209479f, (-1 - 0.5f) / 0.28209479f, 0};
  RenderOptions options;
  options.background = {0.1f, 0.2f, 0.3f};
  Renderer renderer(g);
  Camera camera = front_camera(33, 33);
  const RenderedImage& image = renderer.render(camera, {}, options);
  const int center = 16 * 33 + 16;
  CHECK(image.alpha[center] == doctest::Approx(0.5).epsilon(1e-3));
  CHECK(image.rgb[3 * center] == doctest::Approx(1.55).epsilon(1e-3));
  CHECK(image.rgb[3 * center + 1] == doctest::Approx(0.1).epsilon(1e-3));
  CHECK(image.rgb[3 * center + 2] == doctest::Approx(0.4).epsilon(1e-3));
}

TEST_CASE("splat: degenerate Gaussians draw nothing wrong") {
  const Camera camera = front_camera(70, 50);
  RenderOptions options;
  options.depth = true;
  for (float log_scale : {-1000.0f, -80.0f, 30.0f, 69.0f, 88.0f, 1000.0f}) {
    for (float logit : {-1000.0f, -3.0f, 0.0f, 1000.0f}) {
      Gaussians g = random_scene(20, 3, 61);
      for (auto& s : g.log_scale) s[0] = log_scale;
      for (auto& s : g.log_scale) s[1] = -s[0];
      for (auto& o : g.opacity_logit) o = logit;
      Renderer renderer(g);
      CHECK(all_finite(renderer.render(camera, {}, options)));
      for (auto& s : g.log_scale) s.setConstant(log_scale);
      CHECK(all_finite(Renderer(g).render(camera, {}, options)));
      if (logit < -100) CHECK(renderer.stats().drawn == 0);
    }
  }
  // A Gaussian far larger than the scene covers every pixel evenly.
  const Gaussians huge = one_gaussian(1e20f, 0.6f, 0.5f);
  RenderOptions near;
  near.near = 0.1;
  const RenderedImage everywhere = Renderer(huge).render(camera, {}, near);
  for (float a : everywhere.alpha) CHECK(a == doctest::Approx(0.6));
}

TEST_CASE("splat: degenerate deformations are drawn or skipped and counted") {
  const Gaussians g = random_scene(50, 3, 71);
  const Camera camera = front_camera(70, 50);
  Renderer renderer(g);
  std::vector<RowMatrix3f> F(g.size(), RowMatrix3f::Identity());
  std::vector<Eigen::Vector3f> position = g.position;
  Deformation deformation;
  deformation.F = F.data();
  deformation.position = position.data();
  F[0] = -F[0];
  F[1].setZero();
  F[2].row(0).setZero();
  F[3] *= 1e30f;
  F[4] *= 1e-30f;
  CHECK(all_finite(renderer.render(camera, deformation)));
  CHECK(renderer.stats().skipped == 0);
  F[5](1, 2) = kNan;
  F[6](0, 0) = std::numeric_limits<float>::infinity();
  position[7].y() = kNan;
  position[8].x() = -std::numeric_limits<float>::infinity();
  CHECK(all_finite(renderer.render(camera, deformation)));
  CHECK(renderer.stats().skipped == 4);
  renderer.render(camera, deformation);
  CHECK(renderer.stats().skipped == 4);
  CHECK(renderer.stats().reprojected < 10);
  for (auto& f : F) f.setConstant(kNan);
  CHECK(shows_background_only(renderer.render(camera, deformation)));
  CHECK(renderer.stats().skipped == g.size());
}

TEST_CASE("splat: cameras behind, inside, at the edge, tiny and unusable") {
  const Gaussians g = random_scene(300, 2, 81);
  Renderer renderer(g);
  Camera away = front_camera(40, 40, 50);
  away.world_to_camera = Eigen::Matrix4d::Identity();
  away.world_to_camera.topRightCorner<3, 1>() = Eigen::Vector3d(0, 0, -50);
  CHECK(shows_background_only(renderer.render(away)));
  for (size_t i = 0; i < 20; ++i) {
    const Eigen::Vector3d eye = g.position[i].cast<double>();
    CHECK(all_finite(renderer.render(look_at(eye, eye + Eigen::Vector3d(0.1, 0, 1), {0, -1, 0}, 1.2, 50, 40))));
  }
  CHECK(all_finite(renderer.render(look_at({0, 0, -2}, {30, 0, -2}, {0, -1, 0}, 3.1, 50, 40))));
  CHECK(all_finite(renderer.render(front_camera(1, 1))));
  CHECK(renderer.render(front_camera(17, 1)).alpha.size() == 17);
  Camera bad = front_camera(40, 40);
  bad.fx = 0;
  CHECK_THROWS_AS(renderer.render(bad), Error);
  bad = front_camera(40, 40);
  bad.width = 0;
  CHECK_THROWS_AS(renderer.render(bad), Error);
  bad = front_camera(40, 40);
  bad.world_to_camera(0, 3) = kNan;
  CHECK_THROWS_AS(renderer.render(bad), Error);
  const Gaussians none;
  CHECK(shows_background_only(Renderer(none).render(front_camera(20, 20))));
}

TEST_CASE("splat: a million Gaussians in one tile") {
  Gaussians g;
  g.resize(1000000, 0);
  for (size_t i = 0; i < g.size(); ++i) {
    g.position[i] = {0.001f * static_cast<float>(i % 100), 0.001f * static_cast<float>(i % 77), 0};
    g.log_scale[i].setConstant(-5);
    g.opacity_logit[i] = -5;  // barely visible, so that nothing ends early
  }
  RenderOptions options;
  options.max_pairs = 100000;
  Renderer renderer(g);
  const RenderedImage& image = renderer.render(front_camera(32, 32), {}, options);
  CHECK(all_finite(image));
  CHECK(*std::max_element(image.alpha.begin(), image.alpha.end()) > 0.999f);
}

TEST_CASE("splat: equal depths blend in file order") {
  Gaussians g = one_gaussian(0.2f, 0.9f, 1);
  g.resize(2, 0);
  g.log_scale[1] = g.log_scale[0];
  g.opacity_logit[1] = g.opacity_logit[0];
  g.sh[1].setConstant(-0.5f / 0.28209479f);
  Renderer renderer(g);
  CHECK(renderer.render(front_camera(9, 9)).rgb[3 * (4 * 9 + 4)] > 0.85f);
  std::swap(g.sh[0], g.sh[1]);
  Renderer swapped(g);
  CHECK(swapped.render(front_camera(9, 9)).rgb[3 * (4 * 9 + 4)] < 0.12f);
}

TEST_CASE("splat: opacities of an anti-aliased scene shrink with what the low-pass filter adds to a splat's area") {
  Gaussians g;
  g.resize(1, 0);
  g.log_scale[0].setConstant(std::log(0.004f));
  g.opacity_logit[0] = 2;
  g.position[0] = {0, 0, 2};
  Camera camera;
  camera.width = camera.height = 33;
  camera.fx = camera.fy = 200;
  camera.cx = camera.cy = 16.5;
  RenderOptions options;
  options.near = 0.1;
  const float plain = Renderer(g).render(camera, {}, options).alpha[16 * 33 + 16];
  g.antialiased = true;
  const float compensated = Renderer(g).render(camera, {}, options).alpha[16 * 33 + 16];
  const double variance = std::pow(0.004 * 200 / 2, 2);
  CHECK(plain == doctest::Approx(g.opacity(0)));
  CHECK(compensated == doctest::Approx(g.opacity(0) * variance / (variance + 0.3)).epsilon(1e-5));
}
