// Small scenes for the renderer's tests.
#ifndef PHYSMAS_TESTS_SPLAT_SCENES_H
#define PHYSMAS_TESTS_SPLAT_SCENES_H

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "splat/projection.h"

namespace physmas::splat_test {

// n Gaussians in a unit ball around the origin, sizes and shapes mixed from dots to needles.
inline Gaussians random_scene(size_t n, int degree, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> u(0, 1);
  Gaussians g;
  g.resize(n, degree);
  for (size_t i = 0; i < n; ++i) {
    g.position[i] = 0.4f * Eigen::Vector3f(normal(random), normal(random), normal(random));
    for (int a = 0; a < 3; ++a) g.log_scale[i][a] = -5.5f + 4 * u(random);
    for (float& q : g.rotation[i]) q = normal(random);
    g.opacity_logit[i] = 3 * normal(random);
  }
  for (auto& sh : g.sh) sh = 0.5f * Eigen::Vector3f(normal(random), normal(random), normal(random));
  return g;
}

inline std::vector<splat::RowMatrix3f> random_deformations(size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<splat::RowMatrix3f> F(n);
  for (auto& f : F) {
    for (int k = 0; k < 9; ++k) f.data()[k] = (k % 4 == 0 ? 1.0f : 0.0f) + 0.4f * normal(random);
  }
  return F;
}

// One round Gaussian at the origin: standard deviation [scene units], opacity 0..1, grey value 0..1.
inline Gaussians one_gaussian(float sigma, float opacity, float grey) {
  Gaussians g;
  g.resize(1, 0);
  g.log_scale[0].setConstant(std::log(sigma));
  g.opacity_logit[0] = std::log(opacity / (1 - opacity));
  g.sh[0].setConstant((grey - 0.5f) / 0.28209479f);
  return g;
}

inline Camera front_camera(int width, int height, double distance = 4) {
  return look_at({0, 0, -distance}, {0, 0, 0}, {0, -1, 0}, 0.6, width, height);
}

}  // namespace physmas::splat_test

#endif
