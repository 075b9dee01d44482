#include "bundle/scene_doubts.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "bundle/dense_component.h"

using namespace physmas;
using namespace physmas::bundle;

namespace {

// A ball of radius 1 around (5, 0, 0), and a sky of radius 50 around the same place.
Gaussians ball(size_t n, size_t sky) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  Gaussians g;
  g.resize(n + sky, 0);
  for (size_t i = 0; i < g.size(); ++i) {
    const Eigen::Vector3f d = Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
    g.position[i] = Eigen::Vector3f(5, 0, 0) + (i < n ? 1.0f : 50.0f) * d;
    g.log_scale[i].setConstant(std::log(0.05f));
    g.opacity_logit[i] = 3;
  }
  return g;
}

bool contains(const std::string& text, const std::string& part) {
  INFO(text);
  return text.find(part) != std::string::npos;
}

Image picture(uint8_t alpha, bool colourful) {
  Image view(16, 16, 4);
  for (size_t i = 0; i < 256; ++i) {
    for (int c = 0; c < 3; ++c) view.pixels[4 * i + c] = static_cast<uint8_t>(colourful ? i : 90);
    view.pixels[4 * i + 3] = alpha;
  }
  return view;
}

}  // namespace

TEST_CASE("scene doubts: views that are blank or of one colour, and the likely cause") {
  Gaussians g = ball(500, 0);
  CHECK(scene_doubt(g, {picture(255, true)}).empty());
  CHECK(contains(scene_doubt(g, {picture(255, true), picture(0, true)}), "a view is blank"));
  CHECK(contains(scene_doubt(g, {picture(255, false)}), "of one colour"));
  for (auto& scale : g.log_scale) scale.setConstant(0.05f);
  CHECK(contains(scene_doubt(g, {picture(255, false)}), "a view is of one colour; scales"));
  CHECK(contains(scene_doubt(g, {picture(255, false)}), "--read linear-scales"));
  g = ball(500, 0);
  for (float& logit : g.opacity_logit) logit = -6;
  CHECK(contains(scene_doubt(g, {picture(0, true)}), "opacity below 0.0025: a view is blank"));
  // One that is huge hides nothing else that says so.
  g = ball(500, 0);
  g.log_scale[7].setConstant(5);
  CHECK(scene_doubt(g, {picture(255, true)}).empty());
}

TEST_CASE("dense component: the object within a sky, however many Gaussians the sky has") {
  for (size_t sky : {0, 30, 600}) {
    const Gaussians g = ball(600, sky);
    const DenseComponent object = dense_component(g);
    CHECK(object.count == 600);
    CHECK(object.box.sizes().maxCoeff() < 4);
    for (size_t i = 0; i < 600; ++i) CHECK(object.box.contains(g.position[i].cast<double>()));
    const std::string warning = surroundings_warning(g, object, {100, 0, 0});
    CHECK(warning.empty() == (sky == 0));
    // The crop is in the file's coordinates.
    if (sky > 0) CHECK(contains(warning, "--crop 103"));
  }
}

TEST_CASE("dense component: few Gaussians, and all in one place") {
  for (size_t n : {1, 2, 5, 50}) {
    Gaussians g;
    g.resize(n, 0);
    for (auto& p : g.position) p = {1, 2, 3};
    CHECK(dense_component(g).count == n);
    CHECK(surroundings_warning(g, dense_component(g), {0, 0, 0}).empty());
  }
}
