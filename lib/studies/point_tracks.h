// Tracks and silhouettes of particles seen by a fixed camera, for the paper's motion metrics without a renderer.
#ifndef PHYSMAS_STUDIES_POINT_TRACKS_H
#define PHYSMAS_STUDIES_POINT_TRACKS_H

#include <vector>

#include "metrics/gaussian_tracks.h"
#include "mpm/math/mat3.h"
#include "scene/camera.h"

namespace physmas::studies {

// A fixed pinhole camera in front of the studies' cases, 2 m away, 400 × 400 pixels.
Camera study_camera();

// Particles are drawn as discs of `radius` [m] that face the camera, nearest first; the silhouette is what they cover.
class PointTracker {
 public:
  PointTracker(const Camera& camera, double radius) : camera_(camera), radius_(radius) {}

  // Query particles: those in front at the cell centres of a kGrid × kGrid grid over the silhouette's bounding box.
  std::vector<int> choose_queries(const std::vector<mpm::Vec3d>& rest);
  // Appends one frame: where the queries project to, visible inside the silhouette, and the silhouette's area in
  // pixels.
  void add_frame(const std::vector<mpm::Vec3d>& x, const std::vector<int>& queries, metrics::TargetMotion& motion);

 private:
  void draw(const std::vector<mpm::Vec3d>& x);

  Camera camera_;
  double radius_;
  std::vector<int> front_;  // [height, width] particle in front, -1: none
  std::vector<float> depth_;
};

}  // namespace physmas::studies

#endif
