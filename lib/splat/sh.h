// Real spherical harmonics up to degree 3, in the order and with the signs of 3DGS files (Kerbl et al. 2023).
#ifndef PHYSMAS_SPLAT_SH_H
#define PHYSMAS_SPLAT_SH_H

#include <Eigen/Core>

#include "scene/gaussians.h"

namespace physmas::splat {

// Writes the (degree + 1)^2 basis values in the unit direction d to `basis`. degree: 0..3.
template <typename T>
void sh_basis(int degree, const Eigen::Matrix<T, 3, 1>& d, T* basis) {
  const T x = d.x(), y = d.y(), z = d.z();
  basis[0] = T(0.28209479177387814);
  if (degree < 1) return;
  const T c1 = T(0.4886025119029199);
  basis[1] = -c1 * y;
  basis[2] = c1 * z;
  basis[3] = -c1 * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z;
  const T c2 = T(1.0925484305920792);
  basis[4] = c2 * x * y;
  basis[5] = -c2 * y * z;
  basis[6] = T(0.31539156525252005) * (2 * zz - xx - yy);
  basis[7] = -c2 * x * z;
  basis[8] = T(0.5462742152960396) * (xx - yy);
  if (degree < 3) return;
  basis[9] = T(-0.5900435899266435) * y * (3 * xx - yy);
  basis[10] = T(2.890611442640554) * x * y * z;
  basis[11] = T(-0.4570457994644658) * y * (4 * zz - xx - yy);
  basis[12] = T(0.3731763325901154) * z * (2 * zz - 3 * xx - 3 * yy);
  basis[13] = T(-0.4570457994644658) * x * (4 * zz - xx - yy);
  basis[14] = T(1.445305721320277) * z * (xx - yy);
  basis[15] = T(-0.5900435899266435) * x * (xx - 3 * yy);
}

// Colour in the unit direction d (from the camera to the Gaussian, in the Gaussian's rest frame): 0.5 + the sum over
// the coefficients up to `degree`, cut below 0 and not above 1. sh: at least (degree + 1)^2 colour triples.
inline Eigen::Vector3f sh_color(int degree, const Eigen::Vector3f* sh, const Eigen::Vector3f& d) {
  float basis[16];
  sh_basis<float>(degree, d, basis);
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.5f);
  for (int k = 0; k < sh_coefficient_count(degree); ++k) color += basis[k] * sh[k];
  return color.cwiseMax(0.0f);
}

}  // namespace physmas::splat

#endif
