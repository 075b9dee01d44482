#include "splat/sh_rotation.h"

#include <Eigen/LU>
#include <cmath>

#include "splat/sh.h"

namespace physmas::splat {
namespace {

constexpr int kSamples = 10;

// A function of degree l is known by its values along these ten axes of a dodecahedron: its symmetry group splits the
// harmonics of degrees 1 to 3 into parts that the axes tell apart, so that the least-squares fits below are
// well conditioned. Fitting needs no table of rotation coefficients, whose signs depend on the basis.
struct Sampling {
  Eigen::Matrix<double, 3, kSamples> axes;
  Eigen::Matrix<double, 16, kSamples> fit;  // rows l^2 .. (l + 1)^2 - 1: coefficients of degree l from values

  Sampling() {
    const double golden = (1 + std::sqrt(5.0)) / 2, p = 1 / golden, q = golden;
    axes << 1, 1, 1, -1, 0, 0, p, -p, q, q,  //
        1, 1, -1, 1, p, -p, q, q, 0, 0,      //
        1, -1, 1, 1, q, q, 0, 0, p, -p;
    axes /= std::sqrt(3.0);
    Eigen::Matrix<double, kSamples, 16> values;
    for (int j = 0; j < kSamples; ++j) {
      double basis[16];
      sh_basis<double>(3, axes.col(j), basis);
      for (int k = 0; k < 16; ++k) values(j, k) = basis[k];
    }
    fit.setZero();
    for (int l = 1; l <= 3; ++l) {
      const Eigen::MatrixXd A = values.middleCols(l * l, 2 * l + 1);
      fit.middleRows(l * l, 2 * l + 1) = (A.transpose() * A).inverse() * A.transpose();
    }
  }
};

}  // namespace

void rotate_sh(int degree, const Eigen::Matrix3d& R, Eigen::Vector3f* sh) {
  static const Sampling sampling;
  // Values of each degree's old function in R^T of the axes.
  Eigen::Matrix<double, 3, kSamples> values[4];
  for (auto& v : values) v.setZero();
  for (int j = 0; j < kSamples; ++j) {
    double basis[16];
    sh_basis<double>(degree, R.transpose() * sampling.axes.col(j), basis);
    for (int l = 1; l <= degree; ++l) {
      for (int k = l * l; k < (l + 1) * (l + 1); ++k) values[l].col(j) += basis[k] * sh[k].cast<double>();
    }
  }
  for (int l = 1; l <= degree; ++l) {
    for (int k = l * l; k < (l + 1) * (l + 1); ++k) {
      sh[k] = (values[l] * sampling.fit.row(k).transpose()).cast<float>();
    }
  }
}

}  // namespace physmas::splat
