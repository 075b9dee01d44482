// A static 3D Gaussian scene, held exactly as 3DGS files store it: raw parameters in structure-of-arrays form.
#ifndef PHYSMAS_SCENE_GAUSSIANS_H
#define PHYSMAS_SCENE_GAUSSIANS_H

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace physmas {

// Spherical-harmonic coefficients per colour channel for a degree 0..3.
constexpr int sh_coefficient_count(int degree) {
  return (degree + 1) * (degree + 1);
}

// The constant real spherical harmonic.
constexpr double kShC0 = 0.28209479177387814;

// N Gaussians in file order, scene space (Kerbl et al. 2023). The raw values are kept bit for bit, so that a file
// that is read and written again is unchanged; the activated values below are what rendering and simulation use.
struct Gaussians {
  int sh_degree = 0;  // 0..3
  // Trained with anti-aliasing (Yu et al. 2024): what the low-pass filter of the image adds to a splat's area is taken
  // from its opacity when it is drawn.
  bool antialiased = false;
  std::vector<Eigen::Vector3f> position;       // [N] mean, scene units
  std::vector<Eigen::Vector3f> log_scale;      // [N] natural logarithm of the standard deviation per axis
  std::vector<std::array<float, 4>> rotation;  // [N] quaternion w, x, y, z as stored, not normalised, norm > 0
  std::vector<float> opacity_logit;            // [N] opacity = 1 / (1 + exp(-logit)); may be infinite
  // [N * sh_coefficient_count(sh_degree)] colour triples; Gaussian i owns the block that starts at i * count.
  // Coefficient 0 is the constant term: colour = 0.5 + kShC0 * sh at degree 0.
  std::vector<Eigen::Vector3f> sh;

  size_t size() const { return position.size(); }

  float opacity(size_t i) const { return 1.0f / (1.0f + std::exp(-opacity_logit[i])); }
  Eigen::Vector3f scale(size_t i) const { return log_scale[i].array().exp(); }

  // Rotation matrix of the normalised quaternion.
  Eigen::Matrix3f rotation_matrix(size_t i) const {
    float w = rotation[i][0], x = rotation[i][1], y = rotation[i][2], z = rotation[i][3];
    const float n = std::sqrt(w * w + x * x + y * y + z * z);
    w /= n, x /= n, y /= n, z /= n;
    Eigen::Matrix3f R;
    R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
    return R;
  }

  // Sigma = R diag(scale)^2 R^T, scene units squared.
  Eigen::Matrix3f covariance(size_t i) const {
    const Eigen::Matrix3f M = rotation_matrix(i) * scale(i).asDiagonal();
    return M * M.transpose();
  }

  const Eigen::Vector3f* sh_of(size_t i) const { return &sh[i * sh_coefficient_count(sh_degree)]; }
  // sRGB at degree 0, not cut.
  Eigen::Vector3f base_color(size_t i) const { return (static_cast<float>(kShC0) * sh_of(i)[0]).array() + 0.5f; }

  // Resizes every array to n Gaussians of the given degree; new Gaussians are zero but for a unit rotation.
  void resize(size_t n, int degree) {
    sh_degree = degree;
    position.resize(n, Eigen::Vector3f::Zero());
    log_scale.resize(n, Eigen::Vector3f::Zero());
    rotation.resize(n, {1, 0, 0, 0});
    opacity_logit.resize(n, 0);
    sh.resize(n * sh_coefficient_count(degree), Eigen::Vector3f::Zero());
  }
};

}  // namespace physmas

#endif
