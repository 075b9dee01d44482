#include "splat/deformed_gaussians.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "splat/polar.h"
#include "splat/sh_rotation.h"

namespace physmas::splat {
namespace {

constexpr double kMinScale = 1e-30;  // scene units; the logarithm of zero is not finite

struct Axes {
  Eigen::Matrix3d U;      // a rotation: the directions of the axes
  Eigen::Vector3d scale;  // standard deviations along them
};

// Turns the columns of A among each other until they are orthogonal: one-sided Jacobi (Hestenes 1958), which leaves
// orthogonal columns where they are, and is as exact for the short axes of needles as for the long ones (Demmel and
// Veselic 1992).
void orthogonalise_columns(Eigen::Matrix3d& A) {
  constexpr double kOrthogonal = 1e-15;  // cosine
  bool turned = true;
  for (int sweep = 0; turned && sweep < 30; ++sweep) {
    turned = false;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const double pp = A.col(p).squaredNorm(), qq = A.col(q).squaredNorm(), pq = A.col(p).dot(A.col(q));
        if (!(std::abs(pq) > kOrthogonal * std::sqrt(pp) * std::sqrt(qq))) continue;
        const double zeta = (qq - pp) / (2 * pq);
        const double t = std::copysign(1 / (std::abs(zeta) + std::hypot(1, zeta)), zeta);
        const double c = 1 / std::hypot(1, t), s = c * t;
        const Eigen::Vector3d old = A.col(p);
        A.col(p) = c * old - s * A.col(q);
        A.col(q) = s * old + c * A.col(q);
        turned = true;
      }
    }
  }
}

// Axes of the ellipsoid A A^T.
Axes principal_axes(Eigen::Matrix3d A) {
  orthogonalise_columns(A);
  Axes axes;
  for (int k = 0; k < 3; ++k) axes.scale[k] = A.col(k).norm();
  std::array<int, 3> by_size = {0, 1, 2};
  std::stable_sort(by_size.begin(), by_size.end(), [&](int i, int j) { return axes.scale[i] > axes.scale[j]; });
  const auto [longest, middle, shortest] = by_size;
  axes.U.setIdentity();
  if (!(axes.scale[longest] > 0)) return axes;
  axes.U.col(longest) = A.col(longest) / axes.scale[longest];
  // A flat or inverted F leaves the short axes without a direction, or mirrored: they are any that make a rotation.
  axes.U.col(middle) = axes.scale[middle] > 0 ? Eigen::Vector3d(A.col(middle) / axes.scale[middle])
                                              : Eigen::Vector3d(axes.U.col(longest)).unitOrthogonal();
  const bool even = (longest + 1) % 3 == middle;
  axes.U.col(shortest) = (even ? 1 : -1) * axes.U.col(longest).cross(axes.U.col(middle));
  return axes;
}

void set_shape(const Gaussians& rest, size_t i, const RowMatrix3f& F, Gaussians& out, size_t k) {
  const RestShape shape = rest_shape(rest, i);
  const Axes axes = principal_axes(F.cast<double>() * shape.M.cast<double>());
  for (int a = 0; a < 3; ++a) {
    out.log_scale[k][a] = static_cast<float>(std::log(std::max(axes.scale[a], kMinScale)));
  }
  const Eigen::Quaterniond turn(axes.U);
  std::array<double, 4> q = {turn.w(), turn.x(), turn.y(), turn.z()};
  double side = 0, norm = 0;
  for (int c = 0; c < 4; ++c) side += q[c] * rest.rotation[i][c], norm += q[c] * q[c];
  // Both signs mean the same rotation.
  for (int c = 0; c < 4; ++c) out.rotation[k][c] = static_cast<float>((side < 0 ? -q[c] : q[c]) / std::sqrt(norm));
}

}  // namespace

Gaussians deformed_gaussians(const Gaussians& rest, const Deformation& deformation) {
  std::vector<size_t> kept;
  for (size_t i = 0; i < rest.size(); ++i) {
    if (deformation.position != nullptr && !deformation.position[i].allFinite()) continue;
    if (deformation.F != nullptr && !deformation.F[i].allFinite()) continue;
    kept.push_back(i);
  }
  Gaussians out;
  out.resize(kept.size(), rest.sh_degree);
  out.antialiased = rest.antialiased;
  const int count = sh_coefficient_count(rest.sh_degree);
#pragma omp parallel for schedule(static)
  for (size_t k = 0; k < kept.size(); ++k) {
    const size_t i = kept[k];
    out.position[k] = deformation.position != nullptr ? deformation.position[i] : rest.position[i];
    out.opacity_logit[k] = rest.opacity_logit[i];
    Eigen::Vector3f* sh = &out.sh[k * count];
    std::copy_n(rest.sh_of(i), count, sh);
    if (deformation.F == nullptr || deformation.F[i] == RowMatrix3f::Identity()) {
      out.log_scale[k] = rest.log_scale[i];
      out.rotation[k] = rest.rotation[i];
      continue;
    }
    set_shape(rest, i, deformation.F[i], out, k);
    if (rest.sh_degree > 0) rotate_sh(rest.sh_degree, polar_rotation(deformation.F[i].cast<double>()), sh);
  }
  return out;
}

}  // namespace physmas::splat
