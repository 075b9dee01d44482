// Exact, fast CPU rendering of static and deformed 3D Gaussians: the forward pass of 3D Gaussian Splatting
// (Kerbl et al. 2023) with EWA projection (Zwicker et al. 2001).
#ifndef PHYSMAS_SPLAT_RENDERER_H
#define PHYSMAS_SPLAT_RENDERER_H

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scene/camera.h"
#include "scene/gaussians.h"
#include "splat/binning.h"
#include "splat/projection.h"

namespace physmas::splat {

// What moves from frame to frame (paper, Eq. gaussiantransport). Views of N values each that must live through the
// call; null means the rest state. A Gaussian whose position or F is not finite is skipped and counted.
struct Deformation {
  const Eigen::Vector3f* position = nullptr;  // [N] means, scene space
  const RowMatrix3f* F = nullptr;             // [N] deformation gradients, row-major: Sigma = F Sigma0 F^T
};

struct RenderOptions {
  Eigen::Vector3f background = Eigen::Vector3f::Zero();  // RGB, 0..1
  int max_sh_degree = 3;                                 // 0..3; higher degrees of the Gaussians are left out
  double near = 0;                     // depth from which Gaussians are drawn, scene units; 0: Renderer::default_near()
  const uint8_t* shown = nullptr;      // [N] 0: leave this Gaussian out; null: draw all
  const int32_t* labels = nullptr;     // [N] label per Gaussian, -1: none; needed for the label image
  bool depth = false;                  // also make the depth image
  bool label = false;                  // also make the label image
  int threads = 0;                     // 0: OpenMP's default. The pixels do not depend on it.
  size_t max_pairs = size_t{1} << 25;  // memory cap: splat-tile pairs held at a time (4 bytes each)
};

// Row-major images of width x height pixels.
struct RenderedImage {
  int width = 0, height = 0;
  std::vector<float> rgb;    // [H * W * 3] over the background, not cut above 1
  std::vector<float> alpha;  // [H * W] 1 - transmittance
  std::vector<float> depth;  // [H * W] mean camera depth by weight, scene units; 0 where alpha < 1/255. If asked for.
  std::vector<int32_t>
      label;  // [H * W] label with the largest summed weight, ties to the lower; -1: none. If asked for.
};

struct RenderStats {
  size_t drawn = 0;        // Gaussians that reach a pixel centre's tile
  size_t skipped = 0;      // Gaussians left out because a value was not finite
  size_t reprojected = 0;  // Gaussians whose projection was computed anew; the others stood still
  size_t pairs = 0;        // splat-tile pairs
  double project_seconds = 0, sort_seconds = 0, bin_seconds = 0, raster_seconds = 0;
};

// Renders one scene many times and keeps its buffers, and everything that did not change, between the calls. Not
// thread-safe: one Renderer per caller.
//
// Alpha at a pixel centre is min(0.99, opacity * exp(-q / 2)); below 1/255 it counts as 0. Blending runs front to back
// by depth (float32; ties by file order) and stops before the transmittance would fall below 1e-4. A splat reaches as
// far as its alpha does. Colours come from spherical harmonics in the direction R^T (mean - camera), R the proper polar
// rotation of F. The same input gives the same bytes whatever the number of threads.
class Renderer {
 public:
  // gaussians: not copied; must outlive the renderer and not change.
  explicit Renderer(const Gaussians& gaussians);

  // The image lives until the next call. Throws an Error (exit code 3) when the camera is unusable: no pixels, more
  // than 2^28 of them, focal lengths that are not positive, or values that are not finite.
  const RenderedImage& render(const Camera& camera, const Deformation& deformation = {},
                              const RenderOptions& options = {});

  const RenderStats& stats() const { return stats_; }

  // A hundredth of the scene's size: the diagonal of the box that holds the middle 90 % of the means per axis, so that
  // stray Gaussians do not count. Scene units, > 0.
  double default_near() const { return default_near_; }

 private:
  void project(const Camera& camera, const Deformation& deformation, const RenderOptions& options, int threads);

  const Gaussians& gaussians_;
  double default_near_;
  std::vector<RestShape> rest_;  // [N]; empty until something moves
  ProjectionSetup setup_;        // of the last call
  bool have_setup_ = false;
  std::vector<Eigen::Vector3f> last_position_;  // [N] what splats_ was made from; empty: the rest state
  std::vector<RowMatrix3f> last_F_;             // [N]
  std::vector<Splat> splats_;                   // [N]
  std::vector<uint32_t> depth_key_;             // [N]
  DepthOrder order_;
  TileBins bins_;
  RenderedImage image_;
  RenderStats stats_;
};

}  // namespace physmas::splat

#endif
