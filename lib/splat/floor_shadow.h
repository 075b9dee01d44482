// The floor of a scene under its Gaussians, with the shadows that they throw in light from everywhere above.
//
// A picture's decoration: alpha and depth, and whatever is measured from them, do not know of it.
#ifndef PHYSMAS_SPLAT_FLOOR_SHADOW_H
#define PHYSMAS_SPLAT_FLOOR_SHADOW_H

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "records/run_specification.h"
#include "records/state.h"
#include "scene/image.h"
#include "splat/renderer.h"

namespace physmas::splat {

struct FloorPlane {
  Eigen::Vector3d point;   // scene space
  Eigen::Vector3d normal;  // unit, towards the free side
};

// What things fall onto: the first plane collider that faces up; else the top of the highest box collider below the
// scene, as far as there is one; else the lower wall of the domain.
FloorPlane floor_plane(const RunSpecification& run, const SolverMap& map, const Gaussians& gaussians);

// Every Gaussian is a spot on the plane with the mass that its opacity has across it. Spots are collected in layers of
// growing softness: a spot's layer is that of its height, so that contact shadows are sharp and dark and those of what
// is high up soft and faint, or that of its own width where that is larger. Within a layer what lies above each other
// covers once (1 - exp(-sum)). Layers are finer where they are sharper and always lie in the same place, and a spot is
// shared between the two next to its softness and the four cells next to it, so that shadows move without jumps.
class FloorShadow {
 public:
  // gaussians: at rest; must outlive this. background: RGB of the pictures.
  FloorShadow(const Gaussians& gaussians, const FloorPlane& plane, const Eigen::Vector3f& background);

  // The shadows of this frame.
  void update(const Deformation& deformation);

  // The picture in 8 bits, RGB, with the floor behind the Gaussians: image.rgb + (1 - alpha) (floor - background). The
  // floor is a little darker or lighter than the background, fades into it with the distance from the scene, and is not
  // seen from below. Shadows fade with it.
  Image picture(const RenderedImage& image, const Camera& camera) const;

 private:
  struct Spot {
    float u, v;   // on the plane, in halves of the layers' side, from their middle
    float layer;  // 0..layers - 1, between two; < 0: none
    float mass;   // opacity times area, plane units squared
  };
  Spot spot_of(size_t i, const Eigen::Vector3f& position, const RowMatrix3f& F) const;
  // How much of the floor a pixel would see, and how dark it is there: [H, W] of two floats, 0..1.
  cv::Mat look_at_floor(const Camera& camera) const;

  const Gaussians& gaussians_;
  FloorPlane plane_;
  Eigen::Vector3f background_;
  double size_;                        // of the scene, scene units
  Eigen::Vector3d middle_;             // of the layers, on the plane
  Eigen::Matrix3d to_plane_;           // from the middle to right, forward and height, in the scene's sizes
  Eigen::Matrix<float, 2, 3> across_;  // its first two rows
  std::vector<RowMatrix3f> shape_;     // [N] R diag(scale)
  std::vector<float> opacity_;         // [N]
  std::vector<Spot> spots_;            // [N]
  std::vector<cv::Mat1f> layers_;      // square
  cv::Mat1f light_;                    // what the shadows leave of it, 0..1, as fine as the finest layer
};

}  // namespace physmas::splat

#endif
