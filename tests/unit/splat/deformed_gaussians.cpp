#include "splat/deformed_gaussians.h"

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "splat/polar.h"
#include "splat/sh.h"
#include "splat/sh_rotation.h"
#include "splat/turned_gaussians.h"
#include "unit/splat/checks.h"
#include "unit/splat/scenes.h"

using namespace physmas;
using namespace physmas::splat;
using namespace physmas::splat_test;

namespace {

Eigen::Vector3d random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

Eigen::Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

// The function that the coefficients stand for, summed in double.
Eigen::Vector3d evaluate(int degree, const std::vector<Eigen::Vector3f>& sh, const Eigen::Vector3d& d) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < sh_coefficient_count(degree); ++k) sum += reference_sh(k, d) * sh[k].cast<double>();
  return sum;
}

Eigen::Matrix3d covariance_of(const Gaussians& g, size_t i) {
  const Eigen::Vector3d scale = g.log_scale[i].cast<double>().array().exp();
  const auto& q = g.rotation[i];
  const Eigen::Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  return R * scale.cwiseAbs2().asDiagonal() * R.transpose();
}

}  // namespace

TEST_CASE("splat: turned harmonics have in every direction d the old colour of R^T d") {
  std::mt19937 random(3);
  for (int degree = 0; degree <= 3; ++degree) {
    for (int round = 0; round < 50; ++round) {
      std::vector<Eigen::Vector3f> sh(sh_coefficient_count(degree));
      for (auto& c : sh) c = random_vector(random).cast<float>();
      const std::vector<Eigen::Vector3f> old = sh;
      const Eigen::Matrix3d R = random_rotation(random);
      rotate_sh(degree, R, sh.data());
      for (int k = 0; k < 20; ++k) {
        const Eigen::Vector3d d = random_vector(random).normalized();
        // Coefficients of size 3 are rounded to float once.
        CHECK((evaluate(degree, sh, d) - evaluate(degree, old, R.transpose() * d)).norm() < 3e-6);
      }
      CHECK(sh[0] == old[0]);
    }
  }
}

TEST_CASE("splat: a quarter turn permutes the harmonics of degree 1") {
  // About z, x -> y: the function -y (coefficient 1) becomes the one that is -y at R^T d = (dy, -dx, dz), which is x.
  std::vector<Eigen::Vector3f> sh(4, Eigen::Vector3f::Zero());
  sh[1].setOnes();
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  rotate_sh(1, R, sh.data());
  CHECK(sh[1].norm() < 1e-7);
  CHECK(sh[2].norm() < 1e-7);
  CHECK((sh[3] + Eigen::Vector3f::Ones()).norm() < 1e-6);
}

TEST_CASE("splat: deformed Gaussians have the covariance F Sigma F^T, whatever F") {
  Gaussians rest = random_scene(600, 0, 7);
  std::vector<RowMatrix3f> F = random_deformations(rest.size(), 8);
  for (size_t i = 0; i < rest.size(); ++i) {
    if (i % 6 == 1) F[i].row(0) = -F[i].row(0);       // most of them inverted
    if (i % 6 == 2) F[i].row(1) = F[i].row(0);        // flat
    if (i % 6 == 3) F[i].setZero();                   // a point
    if (i % 6 == 4) rest.log_scale[i] = {3, -9, -9};  // needle
    if (i % 6 == 5) F[i] *= i % 12 == 5 ? 1e8f : 1e-8f;
  }
  Deformation deformation;
  deformation.F = F.data();
  const Gaussians out = deformed_gaussians(rest, deformation);
  REQUIRE(out.size() == rest.size());
  CHECK(out.opacity_logit == rest.opacity_logit);
  for (size_t i = 0; i < rest.size(); ++i) {
    const Eigen::Matrix3d f = F[i].cast<double>();
    const Eigen::Matrix3d expected = f * covariance_of(rest, i) * f.transpose();
    // Relative to the longest axis: scales and quaternions are rounded to float.
    CHECK((covariance_of(out, i) - expected).norm() <= 3e-6 * expected.norm() + 1e-59);
    CHECK(out.log_scale[i].allFinite());
    const auto& q = out.rotation[i];
    CHECK(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] == doctest::Approx(1).epsilon(1e-6));
    // The volume shows what the norm cannot: that the short axes are right, too.
    const double volume = std::abs(f.determinant()) * std::exp(double(rest.log_scale[i].sum()));
    if (i % 6 != 2 && i % 6 != 3) {
      CHECK(std::exp(double(out.log_scale[i].sum())) == doctest::Approx(volume).epsilon(2e-5));
    }
  }
}

TEST_CASE("splat: what does not move keeps its values, and a turn keeps scales and their order") {
  const Gaussians rest = random_scene(200, 3, 9);
  const Gaussians same = deformed_gaussians(rest, {});
  const std::vector<RowMatrix3f> identity(rest.size(), RowMatrix3f::Identity());
  Deformation deformation;
  deformation.F = identity.data();
  const Gaussians still = deformed_gaussians(rest, deformation);
  for (const Gaussians* g : {&same, &still}) {
    CHECK(g->position == rest.position);
    CHECK(g->log_scale == rest.log_scale);
    CHECK(g->rotation == rest.rotation);
    CHECK(g->sh == rest.sh);
  }
  std::mt19937 random(10);
  std::vector<RowMatrix3f> turns(rest.size());
  for (auto& f : turns) f = random_rotation(random).cast<float>();
  deformation.F = turns.data();
  const Gaussians turned = deformed_gaussians(rest, deformation);
  for (size_t i = 0; i < rest.size(); ++i) {
    CHECK((turned.log_scale[i] - rest.log_scale[i]).cwiseAbs().maxCoeff() < 1e-5);
    const auto rotation_of = [](const std::array<float, 4>& q) {
      return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    };
    // Axes of nearly equal length are defined only as well as float32 tells the lengths apart.
    const Eigen::Vector3f s = rest.log_scale[i];
    const float gap = std::min({1.0f, std::abs(s[0] - s[1]), std::abs(s[1] - s[2]), std::abs(s[2] - s[0])});
    CHECK((rotation_of(turned.rotation[i]) - turns[i].cast<double>() * rotation_of(rest.rotation[i])).norm() <
          2e-6 / gap);
  }
}

TEST_CASE("splat: a static viewer sees of the deformed file what the renderer draws") {
  for (int degree = 0; degree <= 3; ++degree) {
    const Gaussians rest = random_scene(400, degree, 90 + degree);
    std::vector<RowMatrix3f> F = random_deformations(rest.size(), 95 + degree);
    std::vector<Eigen::Vector3f> position = rest.position;
    for (size_t i = 0; i < rest.size(); ++i) position[i] += 0.1f * F[i].col(0);
    Deformation deformation;
    deformation.position = position.data();
    deformation.F = F.data();
    F[3](1, 1) = std::numeric_limits<float>::quiet_NaN();
    position[4].x() = std::numeric_limits<float>::infinity();
    const Gaussians out = deformed_gaussians(rest, deformation);
    CHECK(out.size() == rest.size() - 2);
    RenderOptions options;
    options.near = 0.1;  // the default depends on the rest state
    const Camera camera = front_camera(101, 75, 2.5);
    Renderer moving(rest), still(out);
    const RenderedImage& a = moving.render(camera, deformation, options);
    const RenderedImage& b = still.render(camera, {}, options);
    size_t different = 0;
    for (size_t k = 0; k < a.rgb.size(); ++k) different += std::abs(a.rgb[k] - b.rgb[k]) > 1 / 255.0;
    // Only thresholds that rounding to the file's floats tips over.
    CHECK(different < a.rgb.size() / 1000);
  }
}

TEST_CASE("splat: a scene that is turned with its camera looks the same") {
  std::mt19937 random(5);
  const Gaussians rest = random_scene(400, 3, 11);
  Gaussians turned = rest;
  const Eigen::Matrix3d R = random_rotation(random);
  turn_gaussians(turned, R);
  for (size_t i = 0; i < rest.size(); ++i) {
    const Eigen::Matrix3d expected = R * covariance_of(rest, i) * R.transpose();
    CHECK((covariance_of(turned, i) - expected).norm() < 1e-6 * expected.norm());
  }
  CHECK(turned.log_scale == rest.log_scale);
  CHECK(turned.opacity_logit == rest.opacity_logit);
  Camera camera = front_camera(96, 64);
  Renderer first(rest);
  const RenderedImage before = first.render(camera);
  camera.world_to_camera.topLeftCorner<3, 3>() = camera.rotation() * R.transpose();
  Renderer second(turned);
  const RenderedImage after = second.render(camera);
  // Gaussians of almost the same depth may change places, and alphas cross their threshold.
  size_t off = 0;
  for (size_t k = 0; k < before.rgb.size(); ++k) off += std::abs(before.rgb[k] - after.rgb[k]) > 1.0f / 255;
  CHECK(off < before.rgb.size() / 500);
}

TEST_CASE("splat: in a sequence quaternions and axes go on from frame to frame") {
  // Two whole turns while the shortest axis becomes the longest one.
  const Gaussians rest = random_scene(200, 1, 19);
  DeformedSequence sequence(rest);
  Gaussians before = rest;
  const int frames = 60;
  std::vector<RowMatrix3f> F(rest.size());
  Deformation deformation;
  deformation.F = F.data();
  size_t flipped = 0;  // what deformed_gaussians alone would do
  Gaussians alone_before = rest;
  for (int t = 1; t <= frames; ++t) {
    const double s = static_cast<double>(t) / frames;
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(4 * EIGEN_PI * s, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    const Eigen::Matrix3d U = Eigen::Vector3d(1 + 4 * s, 1 - 0.5 * s, 1).asDiagonal();
    for (auto& f : F) f = (R * U).cast<float>();
    sequence.advance(deformation);
    const Gaussians& now = sequence.gaussians();
    const Gaussians alone = deformed_gaussians(rest, deformation);
    for (size_t i = 0; i < rest.size(); ++i) {
      const auto cosine = [i](const Gaussians& a, const Gaussians& b) {
        const Eigen::Vector4d p(a.rotation[i][0], a.rotation[i][1], a.rotation[i][2], a.rotation[i][3]);
        const Eigen::Vector4d q(b.rotation[i][0], b.rotation[i][1], b.rotation[i][2], b.rotation[i][3]);
        return p.normalized().dot(q.normalized());
      };
      flipped += cosine(alone_before, alone) < 0.8;
      // 12 degrees of turn a frame and what the axes turn within the Gaussian; never half a turn of a quaternion, and
      // never more than the 62.8 degrees that lie between numberings of axes.
      CHECK(cosine(before, now) > 0.84);
      const Eigen::Matrix3d expected = F[i].cast<double>() * covariance_of(rest, i) * F[i].cast<double>().transpose();
      CHECK((covariance_of(now, i) - expected).norm() <= 3e-6 * expected.norm());
    }
    before = now;
    alone_before = alone;
  }
  CHECK(flipped > 0);
}

TEST_CASE("splat: in a sequence Gaussians that are not finite stay where they were and are not drawn") {
  const Gaussians rest = random_scene(10, 0, 20);
  DeformedSequence sequence(rest);
  std::vector<Eigen::Vector3f> position = rest.position;
  Deformation deformation;
  deformation.position = position.data();
  for (auto& p : position) p += Eigen::Vector3f(1, 0, 0);
  sequence.advance(deformation);
  CHECK(sequence.gaussians().position == position);
  const Eigen::Vector3f last = position[4];
  position[4].x() = std::numeric_limits<float>::quiet_NaN();
  position[5] *= 2;
  sequence.advance(deformation);
  CHECK(sequence.hidden() == 1);
  CHECK(sequence.gaussians().position[4] == last);
  CHECK(sequence.drawn().size() == 9);
  CHECK(sequence.drawn().position[4] == position[5]);
}
