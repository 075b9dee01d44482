#include "mpm/rigid/small_solve.h"

#include <algorithm>
#include <cmath>

namespace physmas::mpm {

void DenseFactors::factor(int n, const double* A) {
  n_ = n;
  lu_.assign(A, A + static_cast<size_t>(n) * n);
  row_.resize(n);
  loose_.assign(n, 0);
  double scale = 0;
  for (int i = 0; i < n; ++i) scale = std::max(scale, std::fabs(lu_[i * n + i]));
  for (int i = 0; i < n; ++i) {
    int pivot = i;
    for (int j = i + 1; j < n; ++j)
      if (std::fabs(lu_[j * n + i]) > std::fabs(lu_[pivot * n + i])) pivot = j;
    row_[i] = pivot;
    if (!(std::fabs(lu_[pivot * n + i]) > 1e-14 * scale)) {
      row_[i] = i;
      loose_[i] = 1;
      for (int j = i; j < n; ++j) lu_[j * n + i] = 0;
      continue;
    }
    if (pivot != i) std::swap_ranges(lu_.begin() + i * n, lu_.begin() + (i + 1) * n, lu_.begin() + pivot * n);
    for (int j = i + 1; j < n; ++j) {
      const double factor = lu_[j * n + i] /= lu_[i * n + i];
      if (factor == 0) continue;
      for (int k = i + 1; k < n; ++k) lu_[j * n + k] -= factor * lu_[i * n + k];
    }
  }
}

void DenseFactors::solve(double* b) const {
  const int n = n_;
  for (int i = 0; i < n; ++i) std::swap(b[i], b[row_[i]]);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= lu_[i * n + k] * b[k];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) b[i] -= lu_[i * n + k] * b[k];
    b[i] = loose_[i] ? 0 : b[i] / lu_[i * n + i];
  }
}

}  // namespace physmas::mpm
