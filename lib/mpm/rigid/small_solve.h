// Small dense systems of rigid bodies: six unknowns each.
#ifndef PHYSMAS_MPM_RIGID_SMALL_SOLVE_H
#define PHYSMAS_MPM_RIGID_SMALL_SOLVE_H

#include <vector>

#include "mpm/math/mat3.h"

namespace physmas::mpm {

// [a]× : the matrix of b ↦ a × b.
inline Mat3d cross_matrix(const Vec3d& a) {
  return {{{0, -a.z, a.y}, {a.z, 0, -a.x}, {-a.y, a.x, 0}}};
}

// The x of A x = b for an A that can be inverted (Cramer).
inline Vec3d solve3(const Mat3d& A, const Vec3d& b) {
  const Mat3d t = transpose(A);
  const double d = dot(t[0], cross(t[1], t[2]));
  return {dot(b, cross(t[1], t[2])) / d, dot(t[0], cross(b, t[2])) / d, dot(t[0], cross(t[1], b)) / d};
}

// Gaussian elimination with row exchange. A direction that nothing holds (a pivot of nothing but rounding) keeps 0.
class DenseFactors {
 public:
  // A: n × n, row-major.
  void factor(int n, const double* A);
  int size() const { return n_; }
  // b becomes the solution.
  void solve(double* b) const;

 private:
  int n_ = 0;
  std::vector<double> lu_;
  std::vector<int> row_;     // exchanged with, per step
  std::vector<char> loose_;  // per unknown
};

}  // namespace physmas::mpm

#endif
