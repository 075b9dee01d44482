// The forward pass of 3D Gaussian Splatting as plainly as it can be written, in double, every Gaussian at every pixel.
#ifndef PHYSMAS_TESTS_SPLAT_REFERENCE_H
#define PHYSMAS_TESTS_SPLAT_REFERENCE_H

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "splat/projection.h"

namespace physmas::splat_test {

struct ReferenceImage {
  std::vector<double> rgb;
  std::vector<double> alpha, depth;
  std::vector<char> tie;  // a threshold was met so closely that rounding decides about a visible contribution
};

// Direct formulas of the real spherical harmonics, by degree and order, with the sign convention of 3DGS.
inline double reference_sh(int k, const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z(), pi = std::acos(-1.0);
  switch (k) {
    case 0:
      return 0.5 * std::sqrt(1 / pi);
    case 1:
      return -std::sqrt(3 / (4 * pi)) * y;
    case 2:
      return std::sqrt(3 / (4 * pi)) * z;
    case 3:
      return -std::sqrt(3 / (4 * pi)) * x;
    case 4:
      return 0.5 * std::sqrt(15 / pi) * x * y;
    case 5:
      return -0.5 * std::sqrt(15 / pi) * y * z;
    case 6:
      return 0.25 * std::sqrt(5 / pi) * (3 * z * z - 1);
    case 7:
      return -0.5 * std::sqrt(15 / pi) * x * z;
    case 8:
      return 0.25 * std::sqrt(15 / pi) * (x * x - y * y);
    case 9:
      return -0.25 * std::sqrt(35 / (2 * pi)) * y * (3 * x * x - y * y);
    case 10:
      return 0.5 * std::sqrt(105 / pi) * x * y * z;
    case 11:
      return -0.25 * std::sqrt(21 / (2 * pi)) * y * (5 * z * z - 1);
    case 12:
      return 0.25 * std::sqrt(7 / pi) * z * (5 * z * z - 3);
    case 13:
      return -0.25 * std::sqrt(21 / (2 * pi)) * x * (5 * z * z - 1);
    case 14:
      return 0.25 * std::sqrt(105 / pi) * z * (x * x - y * y);
    default:
      return -0.25 * std::sqrt(35 / (2 * pi)) * x * (x * x - 3 * y * y);
  }
}

inline ReferenceImage reference_render(const Gaussians& g, const Camera& camera, const splat::RowMatrix3f* F,
                                       const Eigen::Vector3d& background, double near) {
  struct Item {
    float depth;
    Eigen::Vector2d mean;
    Eigen::Matrix2d inverse;
    double opacity, z;
    Eigen::Vector3d color;
  };
  std::vector<Item> items;
  for (size_t i = 0; i < g.size(); ++i) {
    const Eigen::Vector3d mean = g.position[i].cast<double>(), t = camera.to_camera(mean);
    if (t.z() <= near) continue;
    const auto& r = g.rotation[i];
    const Eigen::Matrix3d R = Eigen::Quaterniond(r[0], r[1], r[2], r[3]).normalized().toRotationMatrix();
    const Eigen::Vector3d scale = g.log_scale[i].cast<double>().array().exp();
    const Eigen::Matrix3d f = F ? Eigen::Matrix3d(F[i].cast<double>()) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    const Eigen::Matrix3d sigma = f * R * scale.cwiseAbs2().asDiagonal() * R.transpose() * f.transpose();
    const double limit_x = 1.3 * 0.5 * camera.width / camera.fx, limit_y = 1.3 * 0.5 * camera.height / camera.fy;
    const double tx = t.z() * std::min(limit_x, std::max(-limit_x, t.x() / t.z()));
    const double ty = t.z() * std::min(limit_y, std::max(-limit_y, t.y() / t.z()));
    Eigen::Matrix<double, 2, 3> J;
    J << camera.fx / t.z(), 0, -camera.fx * tx / (t.z() * t.z()), 0, camera.fy / t.z(),
        -camera.fy * ty / (t.z() * t.z());
    const Eigen::Matrix<double, 2, 3> JW = J * camera.rotation();
    const Eigen::Matrix2d cov = JW * sigma * JW.transpose() + 0.3 * Eigen::Matrix2d::Identity();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d flip(1, 1, svd.matrixU().determinant() * svd.matrixV().determinant());
    const Eigen::Matrix3d polar = svd.matrixU() * flip.asDiagonal() * svd.matrixV().transpose();
    const Eigen::Vector3d direction = (polar.transpose() * (mean - camera.center())).normalized();
    Eigen::Vector3d color = Eigen::Vector3d::Constant(0.5);
    for (int k = 0; k < sh_coefficient_count(g.sh_degree); ++k) {
      color += reference_sh(k, direction) * g.sh_of(i)[k].cast<double>();
    }
    items.push_back({static_cast<float>(t.z()), camera.project(t), cov.inverse(),
                     1 / (1 + std::exp(-double(g.opacity_logit[i]))), t.z(), color.cwiseMax(0)});
  }
  std::vector<size_t> order(items.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return items[a].depth < items[b].depth; });

  ReferenceImage image;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      double T = 1, depth = 0;
      Eigen::Vector3d color = Eigen::Vector3d::Zero();
      char tie = 0;
      for (size_t i : order) {
        const Item& item = items[i];
        const Eigen::Vector2d d = Eigen::Vector2d(x + 0.5, y + 0.5) - item.mean;
        const double alpha = std::min(0.99, item.opacity * std::exp(-0.5 * d.dot(item.inverse * d)));
        tie |= std::abs(alpha * 255 - 1) < 1e-3;
        if (alpha < 1.0 / 255) continue;
        const double next = T * (1 - alpha);
        tie |= std::abs(next / 1e-4 - 1) < 1e-2;
        if (next < 1e-4) break;
        color += alpha * T * item.color;
        depth += alpha * T * item.z;
        T = next;
      }
      color += T * background;
      for (int k = 0; k < 3; ++k) image.rgb.push_back(color[k]);
      image.alpha.push_back(1 - T);
      image.depth.push_back(1 - T < 1.0 / 255 ? 0 : depth / (1 - T));
      image.tie.push_back(tie);
    }
  }
  return image;
}

}  // namespace physmas::splat_test

#endif
