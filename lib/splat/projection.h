// From a 3D Gaussian to a splat in the image: EWA projection, reach and colour.
#ifndef PHYSMAS_SPLAT_PROJECTION_H
#define PHYSMAS_SPLAT_PROJECTION_H

#include <Eigen/Core>
#include <cstdint>

#include "scene/camera.h"
#include "scene/gaussians.h"

namespace physmas::splat {

using RowMatrix3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

constexpr float kMinAlpha = 1.0f / 255.0f;  // smaller contributions are invisible at 8 bits and skipped
constexpr float kMaxAlpha = 0.99f;          // keeps the transmittance positive
constexpr float kMinTransmittance = 1e-4f;  // blending stops before it falls below
constexpr double kLowPass = 0.3;            // added to both image variances [pixels squared]
constexpr double kGuard = 0.3;              // the Jacobian is frozen this part of the half view outside the image

// What never changes about a Gaussian.
struct RestShape {
  RowMatrix3f M;  // R diag(scale): Sigma0 = M M^T, scene units
  float opacity;  // 0..1
};

RestShape rest_shape(const Gaussians& gaussians, size_t i);

// One Gaussian in the image, one cache line. With d = pixel centre - (x, y): u = a dx + b dy, v = c dy,
// q = u^2 + v^2, alpha = 2^(log2_opacity - q log2(e) / 2). The triangular factor instead of the inverse covariance
// keeps long thin splats exact in float: nothing large cancels.
struct alignas(64) Splat {
  double x, y;    // mean [pixels]
  float a, b, c;  // a, c > 0
  float log2_opacity;
  float reach;           // sqrt of the largest q with alpha >= 1/255, rounded up
  float half_x, half_y;  // half the box of the ellipse q <= reach^2 [pixels]
  float color[3];        // RGB, >= 0
  float depth;           // camera z [scene units]
};

// What all Gaussians of one frame share.
struct ProjectionSetup {
  Camera camera;
  double near = 0;
  int sh_degree = 0;  // degree to evaluate
  bool operator==(const ProjectionSetup& other) const;
};

enum class Projection { drawn, hidden, not_finite };

// Projects Gaussian i, placed at `position` and deformed by F, into the image. `splat` is filled in when it is drawn;
// hidden: nearer than the near plane, outside the image, or below alpha 1/255 everywhere.
Projection project_gaussian(const Gaussians& gaussians, size_t i, const RestShape& rest,
                            const Eigen::Vector3f& position, const RowMatrix3f& F, const ProjectionSetup& setup,
                            Splat* splat);

}  // namespace physmas::splat

#endif
