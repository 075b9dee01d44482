// The rotation in a deformation gradient.
#ifndef PHYSMAS_SPLAT_POLAR_H
#define PHYSMAS_SPLAT_POLAR_H

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace physmas::splat {

// The proper rotation (det +1) nearest to F: the polar rotation when det F > 0, and for inverted or singular F the one
// that flips the axis of the smallest singular value. Identity when an entry of F is not finite.
inline Eigen::Matrix3d polar_rotation(const Eigen::Matrix3d& F) {
  const double norm = F.norm();
  if (!std::isfinite(norm) || norm == 0) return Eigen::Matrix3d::Identity();
  Eigen::Matrix3d X = F / norm;
  double det = X.determinant();
  // Newton's iteration with Frobenius scaling (Higham 1986): a handful of steps where F is well away from singular.
  if (det > 1e-7) {
    for (int step = 0; step < 20; ++step) {
      Eigen::Matrix3d Y;  // X^-T, by cofactors
      Y.col(0) = X.col(1).cross(X.col(2)) / det;
      Y.col(1) = X.col(2).cross(X.col(0)) / det;
      Y.col(2) = X.col(0).cross(X.col(1)) / det;
      const double gamma = std::sqrt(Y.norm() / X.norm());
      const Eigen::Matrix3d next = 0.5 * (gamma * X + Y / gamma);
      const double change = (next - X).squaredNorm();
      X = next;
      if (change < 1e-16) return X;  // quadratic: the next change would be below 1e-16
      det = X.determinant();
    }
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F / norm, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if (U.determinant() * svd.matrixV().determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

}  // namespace physmas::splat

#endif
