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

// Among the ways to number the axes and to point them, the one whose rotation is nearest to `before`.
void follow(const Eigen::Matrix3d& before, Axes& axes) {
  const Eigen::Matrix3d cosine = before.transpose() * axes.U;
  static constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  double most = -4;
  int best = 0;
  Eigen::Vector3d signs;
  for (int o = 0; o < 6; ++o) {
    Eigen::Vector3d sign;
    double sum = 0, least = 2;
    int weakest = 0;
    for (int k = 0; k < 3; ++k) {
      const double c = cosine(k, kOrders[o][k]);
      sign[k] = c < 0 ? -1 : 1;
      sum += std::abs(c);
      if (std::abs(c) < least) least = std::abs(c), weakest = k;
    }
    // A rotation has an even number of exchanges and reflections together.
    if (sign.prod() * (o < 3 ? 1 : -1) < 0) {
      sign[weakest] *= -1;
      sum -= 2 * least;
    }
    // Equal within rounding: the order of the rest axes stays.
    if (sum > most + 1e-9) most = sum, best = o, signs = sign;
  }
  const Axes old = axes;
  for (int k = 0; k < 3; ++k) {
    axes.U.col(k) = signs[k] * old.U.col(kOrders[best][k]);
    axes.scale[k] = old.scale[kOrders[best][k]];
  }
}

// q, or -q where that lies nearer to `near`: both mean the same rotation.
std::array<float, 4> on_side_of(const std::array<float, 4>& q, const std::array<float, 4>& near) {
  float side = 0;
  for (int c = 0; c < 4; ++c) side += q[c] * near[c];
  if (side >= 0) return q;
  return {-q[0], -q[1], -q[2], -q[3]};
}

// Whether two rotations are less than 45 degrees apart: then no other numbering of axes is nearer.
bool are_near(const std::array<float, 4>& a, const std::array<float, 4>& b) {
  constexpr double kHalf = 0.924;  // cosine of half the angle
  double ab = 0, aa = 0, bb = 0;
  for (int c = 0; c < 4; ++c) ab += double(a[c]) * b[c], aa += double(a[c]) * a[c], bb += double(b[c]) * b[c];
  return std::abs(ab) > kHalf * std::sqrt(aa) * std::sqrt(bb);
}

// before: the Gaussian in the frame before, or null: the order of the axes is that of the rest ones.
void set_shape(const Gaussians& rest, size_t i, const RowMatrix3f& F, const Gaussians* before, Gaussians& out,
               size_t k) {
  const RestShape shape = rest_shape(rest, i);
  Axes axes = principal_axes(F.cast<double>() * shape.M.cast<double>());
  const Gaussians& reference = before != nullptr ? *before : rest;
  if (before != nullptr) follow(before->rotation_matrix(i).cast<double>(), axes);
  for (int a = 0; a < 3; ++a) {
    out.log_scale[k][a] = static_cast<float>(std::log(std::max(axes.scale[a], kMinScale)));
  }
  const Eigen::Quaterniond turn(axes.U);
  std::array<double, 4> q = {turn.w(), turn.x(), turn.y(), turn.z()};
  double side = 0, norm = 0;
  for (int c = 0; c < 4; ++c) side += q[c] * reference.rotation[i][c], norm += q[c] * q[c];
  // Both signs mean the same rotation.
  for (int c = 0; c < 4; ++c) out.rotation[k][c] = static_cast<float>((side < 0 ? -q[c] : q[c]) / std::sqrt(norm));
}

bool is_finite(const Deformation& deformation, size_t i) {
  return (deformation.position == nullptr || deformation.position[i].allFinite()) &&
         (deformation.F == nullptr || deformation.F[i].allFinite());
}

// Gaussian i of `rest` as Gaussian k of `out`.
void deform(const Gaussians& rest, size_t i, const Deformation& deformation, const Gaussians* before, Gaussians& out,
            size_t k) {
  const int count = sh_coefficient_count(rest.sh_degree);
  out.position[k] = deformation.position != nullptr ? deformation.position[i] : rest.position[i];
  out.opacity_logit[k] = rest.opacity_logit[i];
  Eigen::Vector3f* sh = &out.sh[k * count];
  std::copy_n(rest.sh_of(i), count, sh);
  const bool whole = deformation.F == nullptr || deformation.F[i] == RowMatrix3f::Identity();
  if (whole && (before == nullptr || are_near(rest.rotation[i], before->rotation[i]))) {
    out.log_scale[k] = rest.log_scale[i];
    out.rotation[k] = before != nullptr ? on_side_of(rest.rotation[i], before->rotation[i]) : rest.rotation[i];
    return;
  }
  set_shape(rest, i, whole ? RowMatrix3f(RowMatrix3f::Identity()) : deformation.F[i], before, out, k);
  if (!whole && rest.sh_degree > 0) rotate_sh(rest.sh_degree, polar_rotation(deformation.F[i].cast<double>()), sh);
}

}  // namespace

Gaussians deformed_gaussians(const Gaussians& rest, const Deformation& deformation) {
  std::vector<size_t> kept;
  for (size_t i = 0; i < rest.size(); ++i) {
    if (is_finite(deformation, i)) kept.push_back(i);
  }
  Gaussians out;
  out.resize(kept.size(), rest.sh_degree);
  out.antialiased = rest.antialiased;
#pragma omp parallel for schedule(static)
  for (size_t k = 0; k < kept.size(); ++k) deform(rest, kept[k], deformation, nullptr, out, k);
  return out;
}

DeformedSequence::DeformedSequence(const Gaussians& rest) : rest_(rest), frame_(rest), drawn_(rest.size(), 1) {}

void DeformedSequence::advance(const Deformation& deformation) {
  size_t hidden = 0;
#pragma omp parallel for schedule(static) reduction(+ : hidden)
  for (size_t i = 0; i < rest_.size(); ++i) {
    drawn_[i] = is_finite(deformation, i);
    hidden += drawn_[i] == 0;
    // In place: each Gaussian reads what it was before it is written.
    if (drawn_[i] != 0) deform(rest_, i, deformation, &frame_, frame_, i);
  }
  hidden_ = hidden;
}

Gaussians DeformedSequence::drawn() const {
  if (hidden_ == 0) return frame_;
  Gaussians out;
  out.resize(rest_.size() - hidden_, rest_.sh_degree);
  out.antialiased = rest_.antialiased;
  const size_t count = sh_coefficient_count(rest_.sh_degree);
  size_t k = 0;
  for (size_t i = 0; i < rest_.size(); ++i) {
    if (drawn_[i] == 0) continue;
    out.position[k] = frame_.position[i];
    out.log_scale[k] = frame_.log_scale[i];
    out.rotation[k] = frame_.rotation[i];
    out.opacity_logit[k] = frame_.opacity_logit[i];
    std::copy_n(frame_.sh_of(i), count, &out.sh[k * count]);
    ++k;
  }
  return out;
}

}  // namespace physmas::splat
